"""The window under Xvfb shows walls, robot, boxes and scan; its screenshots are kept."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[3]
SHOTS = ROOT / "build" / "screenshots"
BOX = ROOT / "src" / "flatland_server" / "worlds" / "office" / "box.model.yaml"

pytestmark = pytest.mark.slow


def screenshot(launch, name):
    """A screenshot, kept as a file: colours of shape (height, width, 3)."""
    SHOTS.mkdir(parents=True, exist_ok=True)
    path = SHOTS / name
    subprocess.run(["import", "-window", "root", str(path)], env=launch.environment, check=True)
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def call(launch, service, request):
    subprocess.run(
        ["rosservice", "call", f"/{service}", request], env=launch.environment, check=True
    )


def count_near(pixels, color, tolerance=40):
    return int((np.abs(pixels - np.array(color)).max(axis=2) <= tolerance).sum())


def test_rviz_shows_walls_robot_boxes_and_scan(run, display):
    launch = run(display=display)
    launch.wait_for("running")
    expected = {  # colour in the world's files or our rviz configuration: least number of pixels
        (102, 102, 102): 3000,  # walls
        (194, 145, 87): 100,  # boxes
        (204, 0, 0): 200,  # scan, and the arrow on the robot
    }

    def all_visible():
        view = screenshot(launch, "rviz_office.png")[130:690, 400:1280]  # without menus and panels
        return all(count_near(view, color) >= least for color, least in expected.items())

    launch.wait_until(all_visible, "walls, robot, boxes and scan")

    # A model that is spawned later is shown, until it is deleted.
    boxes = count_near(screenshot(launch, "rviz_office.png"), (194, 145, 87))
    pose = "{x: 2.0, y: 3.0, theta: 0.0}"
    call(launch, "spawn_model", f"{{yaml_path: {BOX}, name: crate, ns: '', pose: {pose}}}")
    launch.wait_until(
        lambda: count_near(screenshot(launch, "rviz_crate.png"), (194, 145, 87)) > boxes + 20,
        "the crate to appear",
    )
    call(launch, "delete_model", "crate")
    launch.wait_until(
        lambda: count_near(screenshot(launch, "rviz_office.png"), (194, 145, 87)) <= boxes,
        "the crate to vanish",
    )

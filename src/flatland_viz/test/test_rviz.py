"""The real rviz under Xvfb: does it show walls, robot, boxes and scan? Its picture is kept."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

SHOTS = Path(__file__).resolve().parents[3] / "build" / "screenshots"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("Xvfb"), reason="Xvfb is not installed"),
]


def screenshot(launch, name):
    """The colours of the screen: shape (height, width, 3). The picture is kept."""
    SHOTS.mkdir(parents=True, exist_ok=True)
    path = SHOTS / name
    subprocess.run(["import", "-window", "root", str(path)], env=launch.environment, check=True)
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def count_near(pixels, color, tolerance=40):
    return int((np.abs(pixels - np.array(color)).max(axis=2) <= tolerance).sum())


def test_rviz_shows_walls_robot_boxes_and_scan(run, display):
    launch = run(display=display)
    launch.wait_for("running")
    expected = {  # colour in the world's files or our rviz configuration: least number of pixels
        (102, 102, 102): 3000,  # walls
        (51, 128, 204): 6,  # robot
        (194, 145, 87): 100,  # boxes
        (204, 0, 0): 200,  # scan
    }

    def all_visible():
        view = screenshot(launch, "rviz_office.png")[130:690, 400:1280]  # without menus and panels
        return all(count_near(view, color) >= least for color, least in expected.items())

    launch.wait_until(all_visible, "walls, robot, boxes and scan")

"""The window of `flatland view` on a virtual screen, with real keys and a mouse.

The red robot is located in screenshots, which stay in build/screenshots.
"""

import os
import subprocess
import sys
import time
from functools import partial

import numpy as np
import pytest
import waiting
from screen_pictures import Screenshots, near
from waiting import LIMIT

pytest.importorskip("pygame")
pytestmark = pytest.mark.slow

wait_until = partial(waiting.wait_until, interval=0.05)  # looks at the screen
SCALE = 0.95 * 800 / 10  # px/m, of the whole world: 10 m in 800 px, with margins
WORLD = """
properties: {}
layers: [{name: walls, map: walls.yaml, color: [0.3, 0.3, 0.3, 1]}]
models: [{name: robot, model: robot.model.yaml}]
"""
ROBOT = """
bodies:
  - name: base
    color: [1, 0, 0, 1]
    footprints: [{type: circle, radius: 0.25, density: 1}]
plugins:
  - {type: DiffDrive, name: drive, body: base}
  - {type: Laser, name: laser, body: base, range: 20, angle: {min: -1, max: 1, increment: 0.01}}
"""


class View:
    """`flatland view` in a folder, on a display."""

    def __init__(self, display, folder):
        self.folder = folder
        self.environment = {**os.environ, "DISPLAY": display}
        self._screenshots = Screenshots(display, "view")
        self.picture = self._screenshots.take
        self.process = subprocess.Popen(
            [sys.executable, "-m", "flatland2d", "view", "world.yaml", "--size", "800x800"],
            cwd=folder,
            env=self.environment,
            stderr=subprocess.PIPE,
            text=True,
        )
        window = wait_until(self._window, "the window")
        self.xdotool("windowfocus", window)
        self.left, self.top = wait_until(lambda: self.robot(), "the robot in the window")

    def _window(self):
        assert self.process.poll() is None, self.process.stderr.read()
        return " ".join(self.xdotool("search", "--onlyvisible", "--class", "^flatland$"))

    def xdotool(self, *arguments):
        command = ["xdotool", *map(str, arguments)]
        result = subprocess.run(
            command, env=self.environment, stdout=subprocess.PIPE, text=True, timeout=LIMIT
        )
        return result.stdout.split()

    def key(self, *keys):
        self.xdotool("key", "--delay", 40, *keys)

    def red(self):
        """The rows and columns of the robot's pixels on the screen."""
        return np.argwhere(near(self.picture("last"), (255, 0, 0), 3))

    def robot(self):
        """Column and row of the robot's middle; None if it is not there."""
        red = self.red()
        return (red[:, 1].mean(), red[:, 0].mean()) if len(red) > 50 else None

    def moved(self):
        """The robot's displacement since the start, to the right and downwards [px]."""
        column, row = self.robot()
        return np.array([column - self.left, row - self.top])

    def hold(self, *keys, until):
        """Holds keys until `until` is true of the robot's displacement."""
        self.xdotool("keydown", *keys)
        try:
            wait_until(lambda: until(*self.moved()), f"what {keys} do")
        finally:
            self.xdotool("keyup", *keys)

    def timeline(self):
        """The columns of the timeline's beginning and of its knob, and their row."""
        rows, columns = np.argwhere(near(self.picture("last"), (70, 110, 170), 3)).T
        return columns.min(), columns.max() - 7, round(np.median(rows))

    def has_beams(self):
        """True if the lidar's beams tint the floor before the robot."""
        column, row = self.robot()
        red, green, _ = map(int, self.picture("beams")[round(row) + 4, round(column) + 60])
        return red > green + 8

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()
        self._screenshots.save()


@pytest.fixture(scope="module")
def window(display, tmp_path_factory):
    """One window for all tests, closed after the last."""
    folder = tmp_path_factory.mktemp("view")
    walls = [(-5, -5, 5, -5), (5, -5, 5, 5), (5, 5, -5, 5), (-5, 5, -5, -5)]
    (folder / "walls.dat").write_text("".join(f"{a} {b} {c} {d}\n" for a, b, c, d in walls))
    (folder / "walls.yaml").write_text(
        "{type: line_segments, data: walls.dat, scale: 1, origin: [0, 0, 0]}\n"
    )
    (folder / "world.yaml").write_text(WORLD)
    (folder / "robot.model.yaml").write_text(ROBOT)
    view = View(display, folder)
    yield view
    view.close()


@pytest.fixture
def view(window):
    """The window, with the whole world and the robot at its start."""
    window.key("r", "Home")
    wait_until(lambda: window.robot() and abs(window.moved()).max() < 2, "the robot at its start")
    return window


def test_keys_drive_a_robot_and_r_puts_it_back(view):
    view.hold("Up", until=lambda right, down: right > 0.5 * SCALE)
    view.hold("w", "a", until=lambda right, down: down < -0.5 * SCALE)
    view.picture("driven")

    view.key("r")
    wait_until(lambda: abs(view.moved()).max() < 2, "the robot to be back")

    view.hold("Down", until=lambda right, down: right < -0.3 * SCALE)
    assert abs(view.moved()[1]) < 3


def test_a_pause_stops_the_robot_and_a_full_stop_makes_single_steps(view):
    view.xdotool("keydown", "Up")
    wait_until(lambda: view.moved()[0] > 10, "the robot to drive")
    view.key("space")

    def is_still():
        before = view.moved()[0]
        time.sleep(0.2)  # several frames
        return view.moved()[0] == before

    wait_until(is_still, "the pause")
    paused = view.moved()[0]
    view.key(*["period"] * 40)  # 0.2 s: 0.1 m
    wait_until(lambda: view.moved()[0] > paused + 0.07 * SCALE, "the single steps")
    view.xdotool("keyup", "Up")
    view.key("space")


def test_the_timeline_shows_the_past_and_the_run_goes_on_from_there(view):
    view.hold("Up", until=lambda right, down: right > 0.8 * SCALE)
    first, last, row = view.timeline()
    latest = view.moved()[0]
    column = round(first + 0.1 * (last - first))

    view.xdotool("mousemove", last, row, "mousedown", 1, "mousemove", last - 50, row)
    view.xdotool("mousemove", column, row, "mouseup", 1)
    wait_until(lambda: abs(view.timeline()[1] - column) < 3, "the knob to follow the mouse")
    view.picture("past")
    past = view.moved()[0]
    assert past < 0.4 * latest

    view.key("End")
    wait_until(lambda: abs(view.moved()[0] - latest) < 3, "the present")
    view.key("Prior")
    wait_until(lambda: abs(view.moved()[0]) < 3, "the beginning")
    view.key("Next", "comma", "comma", "comma")
    wait_until(lambda: abs(view.moved()[0] - latest) < 5, "the end, but for three steps")

    view.xdotool("mousemove", column, row, "click", 1)
    wait_until(lambda: abs(view.moved()[0] - past) < 3, "the robot of the past")
    view.key("space")
    view.hold("Up", until=lambda right, down: right > past + 0.2 * SCALE)


def test_what_the_mouse_does(view):
    size = len(view.red())
    column, row = view.robot()

    view.xdotool("mousemove", round(column), round(row), "click", 4, "click", 4, "click", 4)
    wait_until(lambda: len(view.red()) > 2 * size, "the wheel to enlarge the robot")
    assert abs(view.moved()).max() < 3

    view.xdotool("mousemove", round(column) - 100, round(row) + 100, "mousedown", 1)
    for way in (20, 60, 90):
        view.xdotool("mousemove", round(column) - 100 + way, round(row) + 100 - way)
    view.xdotool("mouseup", 1)
    wait_until(lambda: abs(view.moved() - (90, -90)).max() < 3, "the picture to be dragged")

    column, row = view.robot()
    view.xdotool("mousemove", round(column), round(row), "click", 1)
    wait_until(lambda: abs(view.moved()).max() < 3, "the robot that is clicked to be followed")

    view.key("Home")
    wait_until(lambda: abs(len(view.red()) - size) < 20, "the whole world")


def test_the_other_keys(view):
    view.key("Tab")
    view.xdotool("keydown", "Right", "Up")
    view.picture("followed")
    view.xdotool("keyup", "Right", "Up")
    assert abs(view.moved()).max() < 3, "what is followed stays in the middle"
    view.key("r", "Home")

    wait_until(view.has_beams, "the lidar's beams")
    view.key("l")
    wait_until(lambda: not view.has_beams(), "the beams to go")

    corner = (round(view.left) - 300, round(view.top) - 300)
    view.key("h")
    wait_until(lambda: view.picture("help")[corner[1], corner[0]].min() > 240, "the help")
    view.key("Escape")
    wait_until(lambda: view.picture("help")[corner[1], corner[0]].min() <= 240, "its end")

    view.key("p")
    wait_until((view.folder / "flatland_1.png").is_file, "the picture")

    view.key("ctrl+q")
    assert view.process.wait(LIMIT) == 0
    assert view.process.stderr.read() == ""

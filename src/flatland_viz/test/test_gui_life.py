"""The window and the server, started separately: neither needs the other to run.

The window is light on the processor, too: an unchanged view is not drawn, and stays intact.
"""

import os
import signal
import sys
import time
from pathlib import Path

import pytest
from screen_pictures import near

pytestmark = pytest.mark.slow

BOX = (194, 145, 87)
NO_SERVER = (198, 40, 40)  # background of this state in the status line
TITLE = "Flatland.*"
TICKS = os.sysconf("SC_CLK_TCK")

COVER = """
from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QApplication, QLabel
application = QApplication([])
label = QLabel()
label.setStyleSheet("background: black")
label.setGeometry({}, {}, {}, {})
label.show()
QTimer.singleShot(500, application.quit)
application.exec_()
"""
"""Another program's window, which is in front of ours for half a second."""


def processor_share(program, seconds=2.0):
    """The share of a core that a process takes."""

    def used():
        words = Path(f"/proc/{program.pid}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, words[11:13])) / TICKS

    begin, before = time.monotonic(), used()
    time.sleep(seconds)
    return (used() - before) / (time.monotonic() - begin)


class Office:
    """The office's server alone, and a window that shows it."""

    def __init__(self, screen, ros, office, waiting):
        self.screen, self.ros, self._office, self._waiting = screen, ros, office, waiting
        ros.publish_transform("map", "odom")
        ros.set_parameter("/flatland_viz/frame_rate", 30)
        self.start_server()
        self.window = ros.start_window()
        self._id = screen.wait_for_window(TITLE)
        waiting(lambda: screen.shows_office("life_office"), "the office")
        self.rows, self.columns = screen.view(screen.picture("life_office"))

    def start_server(self):
        self.server = self.ros.start_server(self._office / "world.yaml")

    def view(self, name):
        """A screenshot of the view."""
        return self.screen.picture(name)[self.rows, self.columns]

    def says_no_server(self, name):
        left, _, right, bottom = self.screen.inside(self._id)
        line = self.screen.picture(name)[bottom - self.screen.px(27) : bottom, left:right]
        return near(line, NO_SERVER, 5).sum() > 300

    def boxes(self, name):
        """The number of pixels of boxes."""
        return near(self.view(name), BOX, 30).sum()


@pytest.fixture(scope="module")
def shown(screen, ros, office, waiting):
    return Office(screen, ros, office, waiting)


def test_a_still_view_is_cheap_and_redrawn_when_uncovered(shown, waiting):
    shown.ros.call("/pause")
    waiting(lambda: processor_share(shown.window) < 0.1, "a window at rest")

    before = shown.view("light_before")
    height, width = before.shape[:2]
    left, top = shown.columns.start + width // 4, shown.rows.start + height // 4
    qt = [length // shown.screen.kind.scale for length in (left, top, width // 2, height // 2)]
    cover = shown.ros.start(sys.executable, "-c", COVER.format(*qt))
    waiting(lambda: (shown.view("light_covered") != before).any(), "the other window")
    cover.wait(60)
    waiting(lambda: (shown.view("light_after") == before).all(), "the view")

    assert "media_export" not in shown.ros.log(shown.window)
    shown.ros.call("/resume")
    drive = shown.ros.start(
        *("rostopic", "pub", "-1", "/cmd_vel", "geometry_msgs/Twist"),
        "{linear: {x: 0.3}, angular: {z: 0.3}}",
    )
    waiting(lambda: (shown.view("light_drive") != before).any(), "the robot to drive")
    share = processor_share(shown.window)
    assert share < 0.8, share  # share of a core; load on the machine lowers it
    shown.ros.end(drive)


def test_a_window_outlives_servers_and_a_server_windows(shown, ros, office, waiting):
    screen = shown.screen
    ros.end(shown.server, signal.SIGKILL)
    waiting(lambda: shown.says_no_server("life_no_server"), '"no server"')
    assert shown.window.poll() is None

    # A new run: time starts at 0, and the world is as in its file.
    shown.start_server()
    waiting(lambda: not shown.says_no_server("life_after"), "the status line to recover")
    waiting(lambda: screen.shows_office("life_after"), "the office again")
    # The world appears in several frames.
    boxes = screen.settled(lambda: shown.boxes("life_after"), seconds=2.0)
    ros.spawn(office / "box.model.yaml", "crate", 2.0, 3.0)
    waiting(lambda: shown.boxes("life_crate") > boxes + 10, "a new model")
    assert ros.call("/delete_model", name="crate")["success"]
    waiting(lambda: shown.boxes("life_after") <= boxes, "the model to vanish")
    assert shown.window.poll() is None

    # A second one has a name of its own, and does not end the first. It needs no display for that.
    second = ros.start("env", "DISPLAY=", *ros.window_command())
    assert second.wait(60) == 0
    assert "without a window" in ros.log(second)
    time.sleep(0.2)  # a window that is told to end does so in 50 ms
    assert shown.window.poll() is None

    ros.end(shown.window, signal.SIGKILL)
    before = ros.clock()
    waiting(lambda: ros.clock() > before + 0.5, "simulated time to go on")
    assert shown.server.poll() is None
    assert not ros.state()["paused"]

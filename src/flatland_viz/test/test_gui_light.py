"""The window is light on the processor: an unchanged view is not drawn, and stays intact."""

import os
import sys
import time
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.slow

WALLS, SCAN = (102, 102, 102), (204, 0, 0)
VIEW = (slice(70, 750), slice(0, 1270))  # without menus, tools and status line
TICKS = os.sysconf("SC_CLK_TCK")

COVER = """
from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QApplication, QLabel
application = QApplication([])
label = QLabel()
label.setStyleSheet("background: black")
label.setGeometry(400, 200, 400, 300)
label.show()
QTimer.singleShot(500, application.quit)
application.exec_()
"""
"""Another program's window, which is in front of ours for half a second."""


def processor_share(program, seconds=3.0):
    """The share of a core that a process takes."""

    def used():
        words = Path(f"/proc/{program.pid}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, words[11:13])) / TICKS

    begin, before = time.monotonic(), used()
    time.sleep(seconds)
    return (used() - before) / (time.monotonic() - begin)


def count(pixels, color):
    return int((np.abs(pixels[VIEW] - np.array(color)).max(axis=2) <= 30).sum())


def test_an_unchanged_view_costs_little_and_is_intact_after_another_window(
    screen, ros, office, waiting
):
    ros.set_parameter("/flatland_viz/frame_rate", 30)
    ros.launch_server(office / "world.yaml", "use_rviz:=true")
    window = ros.start("rosrun", "flatland_viz", "flatland_viz")
    screen.wait_for_window("Flatland.*")
    least = {WALLS: 3000, SCAN: 200}

    def shows_office():
        pixels = screen.picture("light_office")
        return all(count(pixels, color) >= number for color, number in least.items())

    waiting(shows_office, "the office")
    ros.call("/pause")

    waiting(lambda: processor_share(window) < 0.1, "a window at rest")

    before = screen.picture("light_before")[VIEW]
    cover = ros.start(sys.executable, "-c", COVER)
    waiting(lambda: (screen.picture("light_covered")[VIEW] != before).any(), "the other window")
    cover.wait(20)
    waiting(lambda: (screen.picture("light_after")[VIEW] == before).all(), "the view", limit=5)

    assert "media_export" not in ros.log(window)
    ros.call("/resume")
    ros.start(
        *("rostopic", "pub", "-1", "/cmd_vel", "geometry_msgs/Twist"),
        "{linear: {x: 0.3}, angular: {z: 0.3}}",
    )
    waiting(lambda: (screen.picture("light_drive")[VIEW] != before).any(), "the robot to drive")
    share = processor_share(window)
    assert 0.1 < share < 0.8, share

"""The window and the server, started separately: neither needs the other to run."""

import signal
import time

import numpy as np
import pytest

pytestmark = pytest.mark.slow

WALLS, BOX, SCAN = (102, 102, 102), (194, 145, 87), (204, 0, 0)
NO_SERVER = (198, 40, 40)  # background of this state in the status line
TITLE = "Flatland.*"


def count(pixels, color, tolerance=30):
    return int((np.abs(pixels - np.array(color)).max(axis=2) <= tolerance).sum())


def shows_office(screen, name):
    pixels = screen.picture(name)[70:750, :1280]  # without menus, tools and status line
    least = {WALLS: 1000, BOX: 100, SCAN: 200}  # an arrow is on the robot
    return all(count(pixels, color) >= number for color, number in least.items())


def settled_count(screen, name, color, waiting):
    """The number of pixels of a colour once it is constant: a world appears bit by bit."""
    seen = []

    def is_settled():
        number = count(screen.picture(name), color)
        if seen and number != seen[-1][1]:
            seen.clear()
        seen.append((time.monotonic(), number))
        return len(seen) > 2 and seen[-1][0] - seen[0][0] >= 2.0

    waiting(is_settled, "a picture that stays the same")
    return seen[-1][1]


def says_no_server(screen, name):
    return count(screen.picture(name)[750:830, :1280], NO_SERVER, tolerance=5) > 300


@pytest.fixture(scope="module")
def start_server(ros, office):
    """Starts the office's server alone, to be killed; returns when it runs."""
    ros.start("rosrun", "tf2_ros", "static_transform_publisher", *[0] * 6, "map", "odom")

    def start():
        program = ros.start(
            *("rosrun", "flatland_server", "flatland_server", "__name:=flatland_server"),
            *(f"_world_path:={office / 'world.yaml'}", "_show_viz:=true"),
        )
        ros.wait_for_clock(program)
        return program

    return start


@pytest.fixture
def open_window(screen, ros, waiting):
    """Opens the window alone; returns when it shows the office."""

    def start():
        program = ros.start("rosrun", "flatland_viz", "flatland_viz")
        screen.wait_for_window(TITLE)
        waiting(lambda: shows_office(screen, "life_before"), "the office")
        return program

    return start


def test_a_window_outlives_servers_and_a_server_windows(
    screen, ros, start_server, open_window, office, waiting
):
    server, window = start_server(), open_window()

    ros.end(server, signal.SIGKILL)
    waiting(lambda: says_no_server(screen, "life_no_server"), '"no server"', limit=20)
    assert window.poll() is None

    # A new run: time starts at 0, and the world is as in its file.
    server = start_server()
    waiting(lambda: not says_no_server(screen, "life_after"), "the status line to recover")
    waiting(lambda: shows_office(screen, "life_after"), "the office again")
    boxes = settled_count(screen, "life_after", BOX, waiting)
    ros.spawn(office / "box.model.yaml", "crate", 2.0, 3.0)
    waiting(lambda: count(screen.picture("life_crate"), BOX) > boxes + 20, "a new model")
    assert ros.call("/delete_model", name="crate")["success"]
    waiting(lambda: count(screen.picture("life_after"), BOX) <= boxes, "the model to vanish")
    assert window.poll() is None

    ros.end(window, signal.SIGKILL)
    before = ros.clock()
    waiting(lambda: ros.clock() > before + 1.0, "simulated time to go on", limit=20)
    assert server.poll() is None
    assert not ros.state()["paused"]

"""The window of scripts/run: closing it ends the launch, and a crash of it does not."""

import os
import signal
import subprocess
import xmlrpc.client

import pytest

TITLE = "Flatland.*"
NAME = "/test_gui_closing"  # ours in calls to the master

pytestmark = pytest.mark.slow


@pytest.fixture
def launch(run, screen, display, waiting):
    """The default world, when the window shows it."""
    launch = run(display=display)
    launch.wait_for("running")
    screen.wait_for_window(TITLE)
    waiting(lambda: screen.shows_office("scripts_run"), "walls, robot, boxes and scan")
    return launch


def pid_of(launch, node):
    uri = xmlrpc.client.ServerProxy(launch.uri).lookupNode(NAME, node)[2]
    return xmlrpc.client.ServerProxy(uri).getPid(NAME)[2]


def test_closing_the_window_ends_the_launch(launch, screen):
    screen.key("ctrl+q")

    assert launch.process.wait(20) == 0
    assert "REQUIRED process [flatland_server" in launch.output
    assert "Traceback" not in launch.output
    assert "escalating" not in launch.output


def test_after_a_crash_of_the_window_the_simulation_goes_on(launch, screen, waiting):
    os.kill(pid_of(launch, "/flatland_viz"), signal.SIGSEGV)

    launch.wait_for("process has died")
    [line] = [line for line in launch.output.splitlines() if "process has died" in line]
    assert "[flatland_viz-" in line
    assert "exit code -11" in line
    screen.wait_until_closed(TITLE)
    command = ["rostopic", "echo", "-n", "50", "/clock"]
    subprocess.run(
        command, env=launch.environment, stdout=subprocess.DEVNULL, timeout=20, check=True
    )

    # Another window, which the launch does not know of.
    command = ["rosrun", "flatland_viz", "flatland_viz"]
    with subprocess.Popen(command, env=launch.environment) as window:
        screen.wait_for_window(TITLE)
        screen.key("ctrl+q")
        assert window.wait(20) == 0
    assert launch.process.poll() is None

    launch.press_ctrl_c()
    assert launch.process.wait(20) == 0

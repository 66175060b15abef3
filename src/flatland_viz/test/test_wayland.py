"""The window and plain rviz on a desktop of Wayland: Qt would draw by Wayland, rviz cannot."""

import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

import pytest
from gui_screen import Screen, wait_until
from plain_rviz import steady_windows
from python_qt_binding.QtCore import QLibraryInfo
from ros_programs import Ros
from screens import SCREENS

pytestmark = pytest.mark.slow

PLUGIN = "platforms/libqwayland-generic.so"


@pytest.fixture(scope="module")
def desktop(tmp_path_factory):
    """The variables of a desktop with Weston and XWayland."""
    plugins = Path(QLibraryInfo.location(QLibraryInfo.PluginsPath))
    if not all(map(shutil.which, ("weston", "Xwayland"))) or not (plugins / PLUGIN).exists():
        pytest.skip("weston, xwayland or qtwayland5 is not installed")
    sockets = Path("/tmp/.X11-unix")  # Weston does not make it
    if not sockets.exists():
        sockets.mkdir()
        sockets.chmod(0o1777)
    log = tmp_path_factory.mktemp("weston") / "weston.log"
    with tempfile.TemporaryDirectory() as runtime, log.open("w") as output:  # short, for a socket
        name = "wayland-test"
        variables = {"XDG_RUNTIME_DIR": runtime, "WAYLAND_DISPLAY": name}
        weston = subprocess.Popen(
            ["weston", "--backend=headless-backend.so", "--xwayland", "--no-config", "-S", name],
            env={**os.environ, **variables},
            stdout=output,
            stderr=subprocess.STDOUT,
        )

        def display():
            assert weston.poll() is None, log.read_text()
            words = log.read_text().partition("xserver listening on display ")[2].split()
            return words and words[0]

        try:
            yield {
                **variables,
                "XDG_SESSION_TYPE": "wayland",
                "DISPLAY": wait_until(display, "an X server"),
            }
        finally:
            weston.terminate()
            weston.wait(10)


@pytest.mark.parametrize(
    ("program", "platform"),
    [("window", {}), ("window", {"QT_QPA_PLATFORM": "wayland"}), ("rviz.launch", {})],
)
def test_it_opens_by_xwayland(desktop, program, platform, tmp_path):
    screen = Screen(desktop["DISPLAY"], SCREENS["1280x800-light"], "wayland", tmp_path)
    steady = {"LD_PRELOAD": steady_windows(tmp_path)} if program == "rviz.launch" else {}
    ros = Ros({**screen.environment, **desktop, **platform, **steady}, tmp_path)
    try:
        if program == "window":
            started, title = ros.start_window(), "Flatland"
        else:
            started, title = ros.start("roslaunch", "flatland_navigation", program), ".*RViz"

        def is_shown():
            assert started.poll() is None, ros.log(started)
            return screen.windows(title)

        wait_until(is_shown, "the window")
        os.killpg(started.pid, signal.SIGINT)
        assert started.wait(60) == 0, ros.log(started)
        assert "parentWindowHandle" not in ros.log(started)
    finally:
        ros.close()

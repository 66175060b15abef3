"""The node flatland_viz: opens the window on the world, or says that there is no display."""

import ctypes
import os
import signal
import sys
import time
import traceback
from pathlib import Path
from typing import Any

import rospkg
import rospy
import yaml

_WAKE_PERIOD = 50  # ms


def main() -> int:
    """Shows the window until it is closed; without a display, waits idly to be ended.

    It does not just exit, because the launch ends with this node: closing the window is meant to.
    """
    if not _has_display():
        rospy.init_node("flatland_viz")
        rospy.logwarn("no display: going on without a window (show_viz:=false avoids this line)")
        rospy.spin()
        return 0
    rospy.init_node("flatland_viz", disable_signals=True)
    return _show_window()


def _has_display() -> bool:
    """Whether the X server that DISPLAY names lets us in.

    A server without clients, such as Xvfb, starts anew when the last one leaves, and refuses others
    for that moment: so this asks again for a second, and its connection stays open until Qt's is.
    """
    try:
        x11 = ctypes.CDLL("libX11.so.6")
    except OSError:
        return False
    x11.XOpenDisplay.restype = ctypes.c_void_p
    for _ in range(10 if os.environ.get("DISPLAY") else 0):
        if x11.XOpenDisplay(None):
            return True
        time.sleep(0.1)
    return False


def _show_window() -> int:
    # Imported here: without a display there need not be Qt or rviz.
    from python_qt_binding.QtCore import Qt, QTimer
    from python_qt_binding.QtWidgets import QApplication

    from flatland_viz.scene import Scene
    from flatland_viz.server import Server
    from flatland_viz.window import Window

    QApplication.setAttribute(Qt.AA_EnableHighDpiScaling)
    QApplication.setAttribute(Qt.AA_UseHighDpiPixmaps)
    application = QApplication(["flatland_viz"])
    application.setApplicationDisplayName("")  # it would be appended to the window's title
    sys.excepthook = _report  # PyQt aborts the process otherwise

    server = Server()
    window = Window(server, Scene(_base_config()))
    server.start()
    window.show()
    window.activateWindow()  # without a window manager nobody else gives it the keyboard

    # rviz has put roscpp's handler in place. Python's run only when Python does: now and then.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: application.quit())
    wake = QTimer(application)
    wake.timeout.connect(lambda: application.quit() if rospy.is_shutdown() else None)
    wake.start(_WAKE_PERIOD)
    application.exec_()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # a second one must not disturb the end
    window.hide()  # at once; the rest takes rospy a second
    server.close()
    rospy.signal_shutdown("the window is closed")
    return 0


def _base_config() -> Any:
    """The rviz configuration that the window starts from."""
    path = Path(rospkg.RosPack().get_path("flatland_viz")) / "rviz" / "flatland.rviz"
    return yaml.safe_load(path.read_text())


def _report(*error: Any) -> None:
    """Says what went wrong in one of the window's actions; the others go on."""
    rospy.logerr("%s", "".join(traceback.format_exception(*error)).rstrip())

"""The node flatland_viz: opens the window, or logs that there is no display."""

import ctypes
import os
import signal
import sys
import threading
import traceback
import xmlrpc.client
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import rosgraph
import rosgraph.names
import rospkg
import rospy
import yaml

from flatland_viz.native import library
from flatland_viz.x_display import choose_x

_WAKE_PERIOD = 50  # ms
_FRAME_RATE = 30  # Hz
_PICTURE_WAIT = 1500  # ms: limit of the wait for a picture of the world
_LONGEST_WAIT = 5000  # ms: limit of the wait for a world before the window opens


_END_SERVER = "--end-server-on-close"
"""The argument that makes closing the window end the server too, and so a launch of both.

A crash of the window does not: the server goes on, and a window can be opened again."""


def main() -> int:
    """Shows the window until it is closed. Without an X display, logs that and ends."""
    missing = choose_x()
    rospy.init_node("flatland_viz", anonymous=_is_second(), disable_signals=True)
    if missing:
        rospy.logwarn("%s: going on without a window (show_viz:=false avoids this line)", missing)
        return 0
    return _show_window(ends_server=_END_SERVER in sys.argv)


def _start_rviz_node() -> None:
    """Starts rviz's ROS node with the remappings of this one; rviz itself uses none."""
    remappings = [each.encode() for each in sys.argv if ":=" in each and not each.startswith("_")]
    values = (ctypes.c_char_p * len(remappings))(*remappings)
    library().flatland_viz_start_roscpp(len(remappings), values)


def _is_second() -> bool:
    """True if there is a window with the usual name, which a node of the same name would end."""
    if any(argument.startswith("__name:=") for argument in sys.argv):
        return False
    with suppress(OSError, xmlrpc.client.Error, rosgraph.MasterException):
        master = rosgraph.Master("/flatland_viz_start")
        name = rosgraph.names.ns_join(rosgraph.names.get_ros_namespace(), "flatland_viz")
        uri = master.lookupNode(name)
        return bool(xmlrpc.client.ServerProxy(uri).getPid("/flatland_viz_start"))
    return False


def _show_window(ends_server: bool) -> int:
    # Imported here: on a machine without a display, Qt and rviz may be missing.
    from python_qt_binding.QtCore import Qt, QTimer
    from python_qt_binding.QtWidgets import QApplication

    from flatland_viz.ending import end_launch, leave, shut_down
    from flatland_viz.garbage import collect_on_this_thread
    from flatland_viz.problem_sources import ProblemSources
    from flatland_viz.scene import Scene
    from flatland_viz.server import Server
    from flatland_viz.services import Services
    from flatland_viz.settings import DARK, Settings
    from flatland_viz.theme import Theme
    from flatland_viz.toolbar import icon
    from flatland_viz.window import Window

    _provide_media_export()
    QApplication.setAttribute(Qt.AA_EnableHighDpiScaling)
    QApplication.setAttribute(Qt.AA_UseHighDpiPixmaps)
    application = QApplication(["flatland_viz"])
    _collection = collect_on_this_thread()
    application.setWindowIcon(icon("flatland"))
    application.setApplicationDisplayName("")  # it would be appended to the window's title
    sys.excepthook = _report  # PyQt aborts the process otherwise
    threading.excepthook = lambda error: _report(*error[:3])

    theme = Theme()
    if Settings().is_on(DARK):
        theme.apply("dark")  # before there are widgets: Qt changes them only once it runs

    problems = ProblemSources()
    problems.start()  # before rviz, which warns about transforms
    server, services = Server(), Services()
    server.models_changed.connect(problems.check_models)
    _start_rviz_node()
    scene = Scene(_base_config(), _frame_rate())
    window = Window(server, services, scene, problems, theme)
    server.start()
    # Opened by a launch file, it waits for the world, since a refused world ends the launch, and
    # so that it opens with a whole picture. A world may have no walls or no models.
    if ends_server:
        scene.framing.whole.connect(lambda: _show(window))
        server.runs.connect(lambda: QTimer.singleShot(_PICTURE_WAIT, lambda: _show(window)))
        QTimer.singleShot(_LONGEST_WAIT, lambda: _show(window))
    else:
        _show(window)

    # rviz has installed roscpp's handlers. Python's run between bytecodes only, hence the timer.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: application.quit())
    wake = QTimer(application)
    wake.timeout.connect(lambda: application.quit() if rospy.is_shutdown() else None)
    wake.start(_WAKE_PERIOD)
    application.exec_()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # a second one must not disturb the shutdown
    window.finish()
    window.hide()  # at once; ROS takes half a second to shut down
    problems.close()
    server.close()
    services.close()
    ends_launch = ends_server and window.is_closed
    shut_down([partial(end_launch, server.shut_down)] if ends_launch else [])
    leave()


def _show(window: Any) -> None:
    if not window.isVisible() and not window.is_closed:
        window.show()
        window.activateWindow()  # gives it the keyboard where there is no window manager


def _base_config() -> Any:
    """The rviz configuration to start from."""
    return yaml.safe_load((_package() / "rviz" / "flatland.rviz").read_text())


def _package() -> Path:
    return Path(rospkg.RosPack().get_path("flatland_viz"))


def _provide_media_export() -> None:
    """Lets rviz find the package media_export, to prevent errors of rospack.

    rviz looks for packages that export media to it. Debian lacks media_export, an empty package.
    """
    with suppress(rospkg.ResourceNotFound):
        rospkg.RosPack().get_path("media_export")
        return
    paths = (os.environ.get("ROS_PACKAGE_PATH"), str(_package() / "ros_packages"))
    os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join(filter(None, paths))


def _frame_rate() -> int:
    """The parameter `~frame_rate`: how often the view is drawn [Hz], 30 unless it is set."""
    value = rospy.get_param("~frame_rate", _FRAME_RATE)
    if isinstance(value, (int, float)) and not isinstance(value, bool) and 1 <= value <= 1000:
        return round(value)
    name = rospy.resolve_name("~frame_rate")
    rospy.logwarn("%s: expected 1 to 1000 [Hz], found %r; using %d", name, value, _FRAME_RATE)
    return _FRAME_RATE


def _report(*error: Any) -> None:
    """Logs an error in one of the window's actions; the window stays open."""
    text = "".join(traceback.format_exception(*error)).rstrip()
    rospy.logerr("an action of the window has failed\n%s", text)

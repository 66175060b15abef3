"""The program `plot`: curves of the numbers on topics over simulated time, in a window.

rqt_plot takes the same names of fields, where it is installed.
"""

import argparse
import signal
import sys
import threading
from collections import deque
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any, Deque, Dict, List, Tuple

import roslib.message
import rospy

from flatland_viz.plotted_values import paths_of, split, value_of

_PERIOD = 100  # ms of real time, between two pictures
_MOST_POINTS = 20_000  # of a curve
_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999")
"""Okabe and Ito's, which people with colour blindness can tell apart."""


class Curves:
    """Subscribes to topics, and keeps the numbers of the last seconds.

    Args:
        names: of topics, or of fields in their messages.
        seconds: length of the curves in simulated time [s].
    """

    def __init__(self, names: List[str], seconds: float) -> None:
        self._waiting = list(names)
        self._seconds = seconds
        self._lock = threading.Lock()  # rospy calls back on threads of its own
        self._points: Dict[str, Deque[Tuple[float, float]]] = {}
        self._paths: Dict[str, List[str]] = {}
        self.has_changed = False

    def subscribe(self) -> List[str]:
        """Subscribes to topics that are there by now; returns the names that are not."""
        topics = dict(rospy.get_published_topics()) if self._waiting else {}
        for name in list(self._waiting):
            topic, path = split(rospy.resolve_name(name), topics)
            message_class = message_class_of(topics[topic]) if topic else None
            if message_class is not None:
                self._waiting.remove(name)
                rospy.Subscriber(topic, message_class, self._receive, (topic, path), queue_size=50)
        return self._waiting

    def read(self) -> Dict[str, List[Tuple[float, float]]]:
        """The points of all curves, by name: time [s], and value."""
        with self._lock:
            self.has_changed = False
            return {name: list(points) for name, points in self._points.items()}

    def _receive(self, message: Any, source: Tuple[str, str]) -> None:
        topic, path = source
        key = f"{topic} {path}"
        if key not in self._paths:
            self._paths[key] = paths_of(message._type, message, path)
        now = _time_of(message)
        with self._lock:
            for each in self._paths[key]:
                value = value_of(message, each)
                if value is not None:
                    self._add(f"{topic}.{each}", now, value)
            self.has_changed = True

    def _add(self, name: str, now: float, value: float) -> None:
        points = self._points.setdefault(name, deque(maxlen=_MOST_POINTS))
        while points and points[-1][0] > now:  # time went back
            points.pop()
        points.append((now, value))
        while points[0][0] < now - self._seconds:
            points.popleft()


def message_class_of(kind: str) -> Any:
    """The class of a message type; None if there is none.

    A publisher has named it, and importing a package could do anything: only one for which genpy
    has made this type is imported.
    """
    package, _, name = kind.partition("/")
    spec = PathFinder.find_spec(package) if package.isidentifier() else None
    folders = (spec.submodule_search_locations if spec is not None and spec.origin else None) or ()
    if not any(Path(folder, "msg", f"_{name}.py").is_file() for folder in folders):
        return None
    return roslib.message.get_message_class(kind)


def _time_of(message: Any) -> float:
    header = getattr(message, "header", None)
    stamp = header.stamp.to_sec() if header is not None else 0.0
    return stamp or rospy.get_time()


def main() -> int:
    """Plots until the window is closed. Returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="plot", description="Plots numbers of topics over simulated time."
    )
    parser.add_argument(
        "names",
        nargs="+",
        metavar="TOPIC[/FIELD]",
        help="such as /scan, /cmd_vel/linear/x or /scan/ranges[0]",
    )
    parser.add_argument(
        "--seconds", type=float, default=60.0, help="that are shown (default: %(default)s)"
    )
    options = parser.parse_args(rospy.myargv()[1:])
    try:
        import python_qt_binding.QtWidgets  # noqa: F401 (pyqtgraph takes the Qt that is loaded)
        import pyqtgraph  # isort: skip
    except ImportError:
        print("plot needs pyqtgraph: apt-get install python3-pyqtgraph", file=sys.stderr)
        return 1
    rospy.init_node("plot", anonymous=True, disable_signals=True)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _show(pyqtgraph, options.names, options.seconds)
    return 0


def _show(pyqtgraph: Any, names: List[str], seconds: float) -> None:
    from flatland_viz.garbage import collect_on_this_thread
    from flatland_viz.settings import DARK, Settings

    background, foreground = ("#1e1f22", "#e1e4e8") if Settings().is_on(DARK) else ("w", "k")
    pyqtgraph.setConfigOptions(background=background, foreground=foreground, antialias=True)
    application = pyqtgraph.mkQApp("plot")
    _collection = collect_on_this_thread()
    plot = pyqtgraph.PlotWidget(title=" ")
    plot.setWindowTitle(f"Plot: {', '.join(names)}")
    plot.setLabel("bottom", "simulated time", units="s")
    plot.showGrid(x=True, y=True, alpha=0.2)
    plot.addLegend()
    plot.resize(720, 360)
    plot.show()
    curves = Curves(names, seconds)
    drawn: Dict[str, Any] = {}

    def update() -> None:
        if rospy.is_shutdown():
            application.quit()
        missing = curves.subscribe()
        plot.setTitle(f"waiting for {', '.join(missing)}" if missing else None)
        if not curves.has_changed:
            return
        for name, points in curves.read().items():
            if name not in drawn:
                pen = pyqtgraph.mkPen(_COLORS[len(drawn) % len(_COLORS)], width=2)
                drawn[name] = plot.plot(name=name.lstrip("/"), pen=pen, connect="finite")
            drawn[name].setData(*zip(*points)) if points else drawn[name].clear()

    timer = pyqtgraph.QtCore.QTimer()
    timer.timeout.connect(update)
    timer.start(_PERIOD)
    application.exec_()
    rospy.signal_shutdown("the window is closed")

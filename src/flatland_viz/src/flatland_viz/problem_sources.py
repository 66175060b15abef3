"""Sources of problems: the server's log, /diagnostics, models, transforms and this window."""

import threading
import time
import xmlrpc.client
from typing import Any, Dict, Iterable, Set, Tuple

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from flatland_msgs.msg import RecentLog
from python_qt_binding.QtCore import QObject, QTimer, Signal
from rosgraph_msgs.msg import Log
from tf2_msgs.msg import TFMessage

from flatland_viz.model_list import Model
from flatland_viz.own_errors import OwnErrors
from flatland_viz.problems import Problem, frames_published_twice, shared_commands
from flatland_viz.transform_warnings import (
    TransformWarnings,
    print_warnings_once,
    take_warnings,
)

_SERVER = "flatland_server"
_LEFT_OUT = ("is switched off", "incoming connection failed")
"""Texts of log messages that are left out: /diagnostics reports failed plugins, too, and rospy logs
an error if another program ends while it connects."""

_FETCH_PERIOD = 500  # ms of real time
_FRAMES_PERIOD = 5.0  # s of real time
_SAMPLE_TIME = 1.0  # s of real time: slow publishers of transforms send some 10 a second
_TRANSFORMS = ("/tf", "/tf_static")
_TRANSFORM_SOURCE, _OWN_SOURCE = "transforms", "window"


class ProblemSources(QObject):
    """Reports problems by a signal, from `start` until `close`."""

    reported = Signal(str, object)
    """The problems of a group, as `Problems.report` takes them."""

    def __init__(self) -> None:
        super().__init__()
        self._server = rospy.resolve_name(_SERVER)
        self._closed = threading.Event()
        self._groups: Dict[str, str] = {}  # of diagnostics, by their nodes
        self._errors = OwnErrors()
        self._own: Dict[str, Problem] = {}  # by their texts, the latest last
        self._warnings = TransformWarnings()
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._report_errors)
        self._timer.timeout.connect(self._report_warnings)

    def start(self) -> None:
        """Begins. Connect the signals before, or in the same event of Qt's loop."""
        self._errors.start()
        print_warnings_once()
        self._timer.start(_FETCH_PERIOD)
        QTimer.singleShot(0, self._subscribe)  # a signal that is not connected yet is lost
        threading.Thread(target=self._watch_frames, name="frames", daemon=True).start()

    def _subscribe(self) -> None:
        rospy.Subscriber(f"{self._server}/recent_log", RecentLog, self._on_log, queue_size=1)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics, queue_size=10)

    def close(self) -> None:
        """Ends the thread. No signal is emitted after this; rospy unsubscribes as it shuts down."""
        self._closed.set()
        self.blockSignals(True)

    def forget(self) -> None:
        """Forgets the window's errors and the warnings of transforms: the world was loaded anew."""
        self._own.clear()
        self._warnings = TransformWarnings()
        self.reported.emit(_OWN_SOURCE, [])
        self._report_warnings()

    def _report_errors(self) -> None:
        name, now = rospy.get_name(), rospy.get_time()
        for text, times in self._errors.take():
            before = self._own.pop(text, None)
            times += before.times if before is not None else 0
            self._own[text] = Problem(name, text, True, times, now)
            self.reported.emit(_OWN_SOURCE, list(self._own.values()))

    def _on_log(self, message: RecentLog) -> None:
        problems = [
            Problem(
                self._server, entry.msg, entry.level >= Log.ERROR, entry.count, entry.stamp.to_sec()
            )
            for entry in message.entries
            if not any(text in entry.msg for text in _LEFT_OUT)
        ]
        self.reported.emit("log", problems)

    def check_models(self, models: Dict[str, Model]) -> None:
        """Reports robots that share a topic of commands."""
        self._last("models", shared_commands(models.values()))

    def _last(self, source: str, warnings: Iterable[str]) -> None:
        """Reports all warnings that a source has now."""
        now = rospy.get_time()
        self.reported.emit(source, [Problem(source, text, False, 1, now) for text in warnings])

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """Each message has all states of its node. Their names begin with the node's."""
        time = message.header.stamp.to_sec()
        problems = [
            Problem(status.name, status.message, status.level >= DiagnosticStatus.ERROR, 1, time)
            for status in message.status
            if status.level > DiagnosticStatus.OK
        ]
        node = message._connection_header["callerid"]
        self._groups[node] = f"/diagnostics of {node}"
        self.reported.emit(self._groups[node], problems)

    def _report_warnings(self) -> None:
        """Fetches the warnings of transforms: their threads must not wait for Python."""
        counts, now = self._warnings.update(take_warnings(), time.monotonic()), rospy.get_time()
        problems = [
            Problem(_TRANSFORM_SOURCE, text, False, times, now) for text, times in counts.items()
        ]
        self.reported.emit("warnings of transforms", problems)

    def _end_diagnostics(self, nodes: Set[str]) -> None:
        """Ends the states of nodes that have ended.

        Args:
            nodes: those that publish diagnostics now.
        """
        for node in self._groups.keys() - nodes:
            self.reported.emit(self._groups.pop(node), [])

    def _watch_frames(self) -> None:
        """Asks the master periodically for nodes; samples transforms if several publish some."""
        master = rosgraph.Master(rospy.get_name())
        while not self._closed.wait(_FRAMES_PERIOD):
            try:
                published, _, _ = master.getSystemState()
            except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
                continue  # there is no master now
            self._end_diagnostics(set(dict(published).get("/diagnostics", ())))
            nodes = {node for topic, names in published if topic in _TRANSFORMS for node in names}
            seen = self._sample_frames() if len(nodes) > 1 else set()
            self._last(_TRANSFORM_SOURCE, frames_published_twice(seen))

    def _sample_frames(self) -> Set[Tuple[str, str, str]]:
        """Parent, child and node of the transforms published within `_SAMPLE_TIME`."""
        seen: Set[Tuple[str, str, str]] = set()

        def note(message: Any) -> None:
            node = message._connection_header["callerid"]
            for each in message.transforms:
                seen.add((each.header.frame_id, each.child_frame_id, node))

        subscribers = [rospy.Subscriber(topic, TFMessage, note) for topic in _TRANSFORMS]
        self._closed.wait(_SAMPLE_TIME)
        for subscriber in subscribers:
            subscriber.unregister()
        return seen

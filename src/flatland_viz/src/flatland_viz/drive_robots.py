"""The robots that can be driven, and the nodes that publish their commands."""

import threading
import xmlrpc.client
from typing import Iterable, List, NamedTuple

import rosgraph
import rospy
from python_qt_binding.QtCore import QObject, Signal

from flatland_viz.model_list import Model

_STEERS = "(TricycleDrive)"
_POLL_PERIOD = 1.0  # s of real time


class Robot(NamedTuple):
    """A model that can be driven."""

    name: str
    topic: str
    """The topic of its commands, geometry_msgs/Twist."""
    steers: bool
    """True if commands have a steering angle instead of a yaw rate."""


def robots_of(models: Iterable[Model]) -> List[Robot]:
    """The models that subscribe to commands."""
    return [
        Robot(model.name, model.command_topic, any(_STEERS in plugin for plugin in model.plugins))
        for model in models
        if model.command_topic
    ]


class PublisherWatch(QObject):
    """Polls the master for other publishers of a topic."""

    changed = Signal(str, object)
    """The topic, and the names of other nodes that publish on it."""

    def __init__(self) -> None:
        super().__init__()
        self._topic = ""
        self._wake = threading.Event()
        self._is_closed = False
        threading.Thread(target=self._poll, name="publishers", daemon=True).start()

    def watch(self, topic: str) -> None:
        """Watches this topic from now on; none if it is empty."""
        if topic != self._topic:
            self._topic = topic
            self._wake.set()

    def close(self) -> None:
        """Ends the thread. No signal is emitted after this."""
        self._is_closed = True
        self._wake.set()

    def _poll(self) -> None:
        master = rosgraph.Master(rospy.get_name())
        while not self._is_closed:
            self._wake.wait(_POLL_PERIOD if self._topic else None)
            self._wake.clear()
            topic = self._topic
            if not topic or self._is_closed:
                continue
            try:
                publishers, _, _ = master.getSystemState()
            except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
                continue  # there is no master now
            nodes = [node for name, names in publishers if name == topic for node in names]
            others = sorted(node for node in nodes if node != rospy.get_name())
            if not self._is_closed:
                self.changed.emit(topic, others)

"""Messages of the server and answers of the ROS master, as Qt signals.

rospy calls back on threads of its own. The signals are delivered by Qt on the window's thread;
nothing here uses a widget.
"""

import threading
import time
import xmlrpc.client
from contextlib import suppress
from typing import Dict, FrozenSet, List, NamedTuple, Optional

import rosgraph
import rospy
from flatland_msgs.msg import DebugTopicList, ModelList, SimulationState
from python_qt_binding.QtCore import QObject, Signal
from std_msgs.msg import UInt8

from flatland_viz.displays import Shown, of_topics
from flatland_viz.model_list import models_of
from flatland_viz.navigation_tools import goal_topics
from flatland_viz.status import Simulation

_SERVER = "flatland_server"
_POLL_PERIOD = 1.0  # s, of real time
_SHUTDOWN_LIMIT = 2.0  # s, of real time: for the server's answer


class Graph(NamedTuple):
    """The part of the ROS master's knowledge that the window uses."""

    displays: List[Shown]
    """The displays of all topics of robots."""
    goals: FrozenSet[str]
    """The topics of goals and initial poses that have subscribers, in any namespace."""
    publishers: Dict[str, List[str]]
    """The names of the nodes that publish a topic, but this one, by topic."""
    world: str
    """The path of the world's file; empty if it is unknown."""


class Server(QObject):
    """Follows the server from `start` until `close`, also before it runs and across restarts."""

    simulation_changed = Signal(object)
    """A status.Simulation, five times a second."""
    runs = Signal()
    """The first message about the simulation has come."""
    graph_changed = Signal(object)
    """A Graph, with the first answer of a master and with each change."""
    loading_changed = Signal(int)
    """Percent of a large world that the server has loaded."""
    models_changed = Signal(object)
    """The Models by name, in natural order."""

    def __init__(self) -> None:
        super().__init__()
        self.debug = rospy.resolve_name(f"{_SERVER}/debug")
        self._graph: Optional[Graph] = None
        self._poll_now = threading.Event()
        self._runs = False
        self._subscribers: List[rospy.Subscriber] = []

    def start(self) -> None:
        """Subscribes to the server. Connect the signals before."""
        self._subscribers = [
            rospy.Subscriber(f"{_SERVER}/{name}", kind, receive, queue_size=1)
            for name, kind, receive in (
                # Models have come or gone, perhaps with their scans.
                ("debug/topics", DebugTopicList, lambda _: self._poll_now.set()),
                ("models", ModelList, lambda m: self.models_changed.emit(models_of(m))),
                ("state", SimulationState, self._on_state),
                ("loading", UInt8, lambda m: self.loading_changed.emit(m.data)),
            )
        ]
        threading.Thread(target=self._poll, name="topics", daemon=True).start()

    def close(self) -> None:
        """Unsubscribes. No signal is emitted after this."""
        self.blockSignals(True)
        self._poll_now.set()
        for subscriber in self._subscribers:
            subscriber.unregister()

    def shut_down(self) -> None:
        """Makes the server end, as `rosnode kill` does. Waits a limited time for its answer."""

        def call() -> None:
            master = rosgraph.Master(rospy.get_name())
            with suppress(OSError, xmlrpc.client.Error, rosgraph.MasterException):
                uri = master.lookupNode(rospy.resolve_name(_SERVER))
                xmlrpc.client.ServerProxy(uri).shutdown(rospy.get_name(), "the window was closed")

        thread = threading.Thread(target=call, name="shut_down", daemon=True)
        thread.start()
        thread.join(_SHUTDOWN_LIMIT)

    def _on_state(self, message: SimulationState) -> None:
        if not self._runs:
            self._runs = True
            self.runs.emit()
        self.simulation_changed.emit(
            Simulation(
                message.stamp.to_sec(),
                message.paused,
                message.rate,
                message.real_time_factor,
                message.history_begin.to_sec(),
                message.history_end.to_sec(),
                message.edits,
                message.undo,
                message.redo,
            ),
        )

    def _poll(self) -> None:
        """Polls the master, which does not notify of new topics."""
        master = rosgraph.Master(rospy.get_name())
        while not self.signalsBlocked():
            self._poll_now.clear()
            # Without a master, the window shows that there is no server.
            with suppress(OSError, xmlrpc.client.Error, rosgraph.MasterException):
                graph = _graph_of(master)
                if graph != self._graph:
                    self._graph = graph
                    self.graph_changed.emit(graph)
            self._poll_now.wait(_POLL_PERIOD)
            time.sleep(0.1)  # several models that are spawned together cause one poll


def _graph_of(master: rosgraph.Master) -> Graph:
    own = rospy.get_name()
    displays = of_topics(master.getPublishedTopics(""), rospy.resolve_name("/tf"))
    published, subscribed, _ = master.getSystemState()
    publishers = dict(published)
    # rviz, which publishes goals, subscribes to show them.
    taken = (topic for topic, nodes in subscribed if {*nodes} - {*publishers.get(topic, ())})
    world = ""
    with suppress(rosgraph.MasterError):  # it is not set
        world = str(master.getParam(rospy.resolve_name(f"{_SERVER}/world_path")))
    return Graph(
        displays,
        goal_topics(taken),
        {topic: sorted(node for node in nodes if node != own) for topic, nodes in published},
        world,
    )

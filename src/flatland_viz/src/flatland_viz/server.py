"""The server as the window sees it: ROS on one side, Qt's signals on the other.

rospy's callbacks come on threads of its own. What they bring leaves as signals, which Qt delivers
on the thread of the window; nothing here touches a widget.
"""

import threading
import time
import xmlrpc.client
from typing import Any, Callable, Dict, List, Optional

import rosgraph
import rospy
from flatland_msgs.msg import DebugTopicList, SimulationState
from flatland_msgs.srv import ChangeRate
from python_qt_binding.QtCore import QObject, Signal
from std_srvs.srv import Empty
from visualization_msgs.msg import MarkerArray

from flatland_viz.bounds import bounds_of_markers
from flatland_viz.displays import laser_scans, layer_topics
from flatland_viz.status import Simulation

_SERVER = "flatland_server"
_POLL_PERIOD = 1.0  # s, of real time


class Server(QObject):
    """Follows the server from the start, whether it is there yet or not, until `close`."""

    simulation_changed = Signal(object)
    """A status.Simulation, five times a second."""
    topics_changed = Signal(object, object)
    """What the server lists on ~debug/topics, and the topics of all laser scans: lists of text."""
    walls_changed = Signal(str, object)
    """A layer's topic, and the Bounds of its walls; None if it has none or is gone."""
    world_changed = Signal(str)
    """The path of the world's file."""
    failed = Signal(str)
    """A service that was called has failed: why."""

    def __init__(self) -> None:
        super().__init__()
        self.debug = rospy.resolve_name(f"{_SERVER}/debug")
        self.handles = rospy.resolve_name("interactive_model_markers/update")
        self._lock = threading.Lock()
        self._layers: Dict[str, rospy.Subscriber] = {}
        self._listed: List[str] = []
        self._scans: List[str] = []
        self._world = ""
        self._poll_now = threading.Event()
        self._is_closed = False
        self._subscribers: List[rospy.Subscriber] = []

    def start(self) -> None:
        """Begins to listen. Connect the signals before."""
        state = rospy.resolve_name(f"{_SERVER}/state")
        self._subscribers = [
            rospy.Subscriber(f"{self.debug}/topics", DebugTopicList, self._on_topics),
            rospy.Subscriber(state, SimulationState, self._on_state, queue_size=1),
        ]
        threading.Thread(target=self._poll, name="topics", daemon=True).start()

    def close(self) -> None:
        """No signal comes after this."""
        self._is_closed = True
        self._poll_now.set()
        for subscriber in [*self._subscribers, *self._layers.values()]:
            subscriber.unregister()

    def pause(self) -> None:
        """Stops simulated time."""
        self._call("pause", Empty)

    def resume(self) -> None:
        """Lets simulated time go on."""
        self._call("resume", Empty)

    def change_rate(self, rate: float) -> None:
        """Sets how many seconds are simulated per second of real time; may be infinite."""
        self._call("change_rate", ChangeRate, rate)

    def _call(self, name: str, service: Any, *arguments: Any) -> None:
        """Calls a service on a thread of its own; `failed` if that does not succeed."""

        def call() -> None:
            try:
                response = rospy.ServiceProxy(name, service)(*arguments)
            except (rospy.ServiceException, rospy.ROSException) as error:
                self._tell(self.failed, f"{name}: {error}")
                return
            if not getattr(response, "success", True):
                self._tell(self.failed, f"{name}: {response.message}")

        threading.Thread(target=call, name=name, daemon=True).start()

    def _tell(self, signal: Any, *values: Any) -> None:
        if not self._is_closed:
            signal.emit(*values)

    def _on_state(self, message: SimulationState) -> None:
        self._tell(
            self.simulation_changed,
            Simulation(
                message.stamp.to_sec(), message.paused, message.rate, message.real_time_factor
            ),
        )

    def _on_topics(self, message: DebugTopicList) -> None:
        with self._lock:
            self._listed = list(message.topics)
            self._follow_layers(layer_topics(self.debug, message.topics))
            self._tell(self.topics_changed, self._listed, self._scans)
        self._poll_now.set()

    def _follow_layers(self, topics: List[str]) -> None:
        for topic in [topic for topic in self._layers if topic not in topics]:
            self._layers.pop(topic).unregister()
            self._tell(self.walls_changed, topic, None)
        for topic in topics:
            if topic not in self._layers:
                self._layers[topic] = rospy.Subscriber(
                    topic, _Unread, self._on_walls(topic), queue_size=1, buff_size=2**24
                )

    def _on_walls(self, topic: str) -> Callable[["_Unread"], None]:
        return lambda message: self._tell(
            self.walls_changed, topic, bounds_of_markers(message.data)
        )

    def _poll(self) -> None:
        """Asks the master, for nobody tells of new topics."""
        master = rosgraph.Master(rospy.get_name())
        while not self._is_closed:
            self._poll_now.clear()
            try:
                scans = laser_scans(master.getPublishedTopics(""))
                world = _parameter(master, rospy.resolve_name(f"{_SERVER}/world_path"))
            except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
                pass  # the master is away; so is the server, which the window says
            else:
                self._on_polled(scans, world)
            self._poll_now.wait(_POLL_PERIOD)
            time.sleep(0.1)  # a burst of new models asks once

    def _on_polled(self, scans: List[str], world: Optional[str]) -> None:
        with self._lock:
            if scans != self._scans:
                self._scans = scans
                self._tell(self.topics_changed, self._listed, scans)
            if world and world != self._world:
                self._world = world
                self._tell(self.world_changed, world)


class _Unread(MarkerArray):
    """A MarkerArray whose bytes are left as they came."""

    __slots__ = ["data"]

    def deserialize(self, buff: bytes) -> "_Unread":
        """Keeps the bytes."""
        self.data = bytes(buff)
        return self


def _parameter(master: rosgraph.Master, name: str) -> Optional[str]:
    try:
        return str(master.getParam(name))
    except rosgraph.MasterError:  # it is not set
        return None

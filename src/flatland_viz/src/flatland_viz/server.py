"""The connection to the server: ROS messages become Qt signals.

rospy calls back on threads of its own. The signals are delivered by Qt on the window's thread;
nothing here uses a widget.
"""

import threading
import time
import xmlrpc.client
from contextlib import suppress
from typing import Any, List, Optional

import rosgraph
import rospy
from flatland_msgs.msg import DebugTopicList, SimulationState
from flatland_msgs.srv import ChangeRate
from python_qt_binding.QtCore import QObject, Signal
from std_msgs.msg import UInt8
from std_srvs.srv import Empty

from flatland_viz.displays import laser_scans
from flatland_viz.error_text import error_text
from flatland_viz.status import Simulation

_SERVER = "flatland_server"
_POLL_PERIOD = 1.0  # s, of real time
_SHUTDOWN_LIMIT = 2.0  # s, of real time: for the server's answer


class Server(QObject):
    """Follows the server from `start` until `close`, also before it runs and across restarts."""

    simulation_changed = Signal(object)
    """A status.Simulation, five times a second."""
    scans_changed = Signal(object)
    """The topics of all laser scans; at first also if there are none."""
    world_changed = Signal(str)
    """The path of the world's file."""
    loading_changed = Signal(int)
    """Percent of a large world that the server has loaded."""
    failed = Signal(str)
    """The error of a service call."""

    def __init__(self) -> None:
        super().__init__()
        self.debug = rospy.resolve_name(f"{_SERVER}/debug")
        self.handles = rospy.resolve_name("interactive_model_markers/update")
        self._scans: Optional[List[str]] = None
        self._world = ""
        self._poll_now = threading.Event()
        self._is_closed = False
        self._subscribers: List[rospy.Subscriber] = []

    def start(self) -> None:
        """Subscribes to the server. Connect the signals before."""
        state = rospy.resolve_name(f"{_SERVER}/state")
        self._subscribers = [
            rospy.Subscriber(f"{self.debug}/topics", DebugTopicList, self._on_topics),
            rospy.Subscriber(state, SimulationState, self._on_state, queue_size=1),
            rospy.Subscriber(rospy.resolve_name(f"{_SERVER}/loading"), UInt8, self._on_loading),
        ]
        threading.Thread(target=self._poll, name="topics", daemon=True).start()

    def close(self) -> None:
        """Unsubscribes. No signal is emitted after this."""
        self._is_closed = True
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

    def pause(self) -> None:
        """Stops simulated time."""
        self._call("pause", Empty)

    def resume(self) -> None:
        """Resumes simulated time."""
        self._call("resume", Empty)

    def change_rate(self, rate: float) -> None:
        """Sets how many seconds are simulated per second of real time; may be infinite."""
        self._call("change_rate", ChangeRate, rate)

    def _call(self, name: str, service: Any, *arguments: Any) -> None:
        """Calls a service on a thread of its own; emits `failed` if that does not succeed."""

        def call() -> None:
            try:
                response = rospy.ServiceProxy(name, service)(*arguments)
            except (rospy.ServiceException, rospy.ROSException) as error:
                self._emit(self.failed, f"{name}: {error}")
                return
            if not getattr(response, "success", True):
                self._emit(self.failed, f"{name}: {error_text(response.message)}")

        threading.Thread(target=call, name=name, daemon=True).start()

    def _emit(self, signal: Any, *values: Any) -> None:
        if not self._is_closed:
            signal.emit(*values)

    def _on_state(self, message: SimulationState) -> None:
        self._emit(
            self.simulation_changed,
            Simulation(
                message.stamp.to_sec(), message.paused, message.rate, message.real_time_factor
            ),
        )

    def _on_loading(self, message: UInt8) -> None:
        self._emit(self.loading_changed, message.data)

    def _on_topics(self, _: DebugTopicList) -> None:
        self._poll_now.set()  # models have come or gone, perhaps with their scans

    def _poll(self) -> None:
        """Polls the master, which does not notify of new topics."""
        master = rosgraph.Master(rospy.get_name())
        while not self._is_closed:
            self._poll_now.clear()
            try:
                scans = laser_scans(master.getPublishedTopics(""))
                world = _parameter(master, rospy.resolve_name(f"{_SERVER}/world_path"))
            except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
                pass  # there is no master now; the window shows that there is no server
            else:
                self._on_polled(scans, world)
            self._poll_now.wait(_POLL_PERIOD)
            time.sleep(0.1)  # several models that are spawned together cause one poll

    def _on_polled(self, scans: List[str], world: Optional[str]) -> None:
        if scans != self._scans:
            self._scans = scans
            self._emit(self.scans_changed, scans)
        if world and world != self._world:
            self._world = world
            self._emit(self.world_changed, world)


def _parameter(master: rosgraph.Master, name: str) -> Optional[str]:
    try:
        return str(master.getParam(name))
    except rosgraph.MasterError:  # it is not set
        return None

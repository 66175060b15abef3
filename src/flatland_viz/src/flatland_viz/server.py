"""The connection to the server: ROS messages become Qt signals.

rospy calls back on threads of its own. The signals are delivered by Qt on the window's thread;
nothing here uses a widget.
"""

import threading
import time
import xmlrpc.client
from contextlib import suppress
from typing import Any, Callable, Dict, FrozenSet, List, Optional, Tuple, Union

import rosgraph
import rospy
from flatland_msgs.msg import DebugTopicList, ModelList, SimulationState
from flatland_msgs.srv import (
    ChangeRate,
    DeleteModel,
    MoveModel,
    OpenWorld,
    Reset,
    SaveWorld,
    Seek,
    SpawnModel,
    Step,
)
from geometry_msgs.msg import Pose2D
from python_qt_binding.QtCore import QObject, Signal
from std_msgs.msg import UInt8
from std_srvs.srv import Empty, Trigger

from flatland_viz.displays import Shown, of_topics
from flatland_viz.error_text import error_text
from flatland_viz.model_list import models_of
from flatland_viz.navigation_tools import goal_topics
from flatland_viz.status import Simulation

Pose = Tuple[float, float, float]
"""x, y [m] and yaw [rad]."""

_SERVER = "flatland_server"
_POLL_PERIOD = 1.0  # s, of real time
_SHUTDOWN_LIMIT = 2.0  # s, of real time: for the server's answer


class Server(QObject):
    """Follows the server from `start` until `close`, also before it runs and across restarts."""

    simulation_changed = Signal(object)
    """A status.Simulation, five times a second."""
    runs = Signal()
    """The first message about the simulation has come."""
    displays_changed = Signal(object)
    """The displays of all topics of robots; emitted once at the start even if there are none."""
    navigation_changed = Signal(object)
    """The topics of goals and initial poses that have subscribers, in any namespace."""
    publishers_changed = Signal(object)
    """The names of the nodes that publish a topic, but this one, by topic."""
    world_changed = Signal(str)
    """The path of the world's file."""
    loading_changed = Signal(int)
    """Percent of a large world that the server has loaded."""
    models_changed = Signal(object)
    """The Models by name, in natural order."""
    failed = Signal(str)
    """The error of a service call."""
    refused = Signal(str, str)
    """A refused change of world: a title, and the reason, which may have many lines."""
    done = Signal(str)
    """A message about a successful service call."""
    renewed = Signal()
    """The world was reset or loaded by this window."""
    _succeeded = Signal(object)
    """A function to call on the window's thread."""

    def __init__(self) -> None:
        super().__init__()
        self.debug = rospy.resolve_name(f"{_SERVER}/debug")
        self._displays: Optional[List[Shown]] = None
        self._navigation: FrozenSet[str] = frozenset()
        self._publishers: Dict[str, List[str]] = {}
        self._world = ""
        self._poll_now = threading.Event()
        self._is_closed = False
        self._runs = False
        self._subscribers: List[rospy.Subscriber] = []
        self._succeeded.connect(lambda then: then())

    def start(self) -> None:
        """Subscribes to the server. Connect the signals before."""
        state = rospy.resolve_name(f"{_SERVER}/state")
        self._subscribers = [
            rospy.Subscriber(f"{self.debug}/topics", DebugTopicList, self._on_topics),
            rospy.Subscriber(
                rospy.resolve_name(f"{_SERVER}/models"), ModelList, self._on_models, queue_size=1
            ),
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

    def spawn(
        self, file: str, name: str, namespace: str, pose: Pose, then: Callable[[], None]
    ) -> None:
        """Spawns a model of a file; calls `then` if that succeeds."""
        self._call("spawn_model", SpawnModel, file, name, namespace, Pose2D(*pose), then=then)

    def delete(self, name: str, then: Callable[[], None]) -> None:
        """Deletes a model; calls `then` if that succeeds."""
        self._call("delete_model", DeleteModel, name, then=then)

    def move(self, name: str, pose: Pose, then: Callable[[], None]) -> None:
        """Moves a model; calls `then` if that succeeds."""
        self._call("move_model", MoveModel, name, Pose2D(*pose), then=then)

    def undo(self, then: Callable[[], None]) -> None:
        """Undoes the latest edit of any client; calls `then` if that succeeds."""
        self._call("undo", Trigger, then=then, done=_message)

    def redo(self, then: Callable[[], None]) -> None:
        """Does again what was undone last; calls `then` if that succeeds."""
        self._call("redo", Trigger, then=then, done=_message)

    def step(self, count: int) -> None:
        """Makes steps while the simulation is paused."""
        steps = "1 step" if count == 1 else f"{count} steps"
        self._call(
            *("step", Step, count, [], 0.0),
            done=lambda response: f"{steps}, to {response.time.to_sec():.3f} s",
        )

    def seek(self, time: float) -> None:
        """Pauses, and goes to a time of the run [s]."""
        self._call("seek", Seek, time)

    def reset(self) -> None:
        """Resets the world to the state in which it was loaded."""
        self._call(
            *("reset", Reset, False, False, 0),
            then=self.renewed.emit,
            done="The world is as it was loaded.",
            refused="The world is not reset",
        )

    def reload(self) -> None:
        """Loads the world again from its files."""
        self._call(
            *("reload_world", Trigger),
            then=self.renewed.emit,
            done="The world's files are loaded.",
            refused="The files are not loaded",
        )

    def save(self, path: str, then: Optional[Callable[[], None]] = None) -> None:
        """Saves moved, spawned and deleted models in the world's file, or in a copy of it.

        Args:
            path: of the copy; empty for the world's own file.
            then: called after success.
        """
        done = f"Saved {path}" if path else "The world's file is saved."
        refused = "The world is not saved"
        self._call("save_world", SaveWorld, path, then=then, done=done, refused=refused)

    def open(self, path: str) -> None:
        """Opens another world in place of this one."""
        self._call(
            *("open_world", OpenWorld, path),
            then=self.renewed.emit,
            done=f"Opened {path}",
            refused=f"{path} is not opened",
        )

    def _call(
        self,
        name: str,
        service: Any,
        *arguments: Any,
        then: Optional[Callable[[], None]] = None,
        done: Union[str, Callable[[Any], str]] = "",
        refused: str = "",
    ) -> None:
        """Calls a service on a thread of its own; emits `failed` if that does not succeed.

        Args:
            name: name of the service, such as "/pause".
            service: class of the service.
            arguments: the request's arguments.
            then: called on the window's thread after success.
            done: a message for `done` on success, or a function that makes it of the response.
            refused: the title for `refused`, which is then emitted instead of `failed`.
        """

        def fail(error: str) -> None:
            if refused:
                self._emit(self.refused, refused, error)
            else:
                self._emit(self.failed, f"{name}: {error}")

        def call() -> None:
            try:
                response = rospy.ServiceProxy(name, service)(*arguments)
            except (rospy.ServiceException, rospy.ROSException) as error:
                fail(str(error))
                return
            if not getattr(response, "success", True):
                fail(error_text(response.message))
                return
            if then is not None:
                self._emit(self._succeeded, then)
            if done:
                self._emit(self.done, done(response) if callable(done) else done)

        threading.Thread(target=call, name=name, daemon=True).start()

    def _emit(self, signal: Any, *values: Any) -> None:
        if not self._is_closed:
            signal.emit(*values)

    def _on_state(self, message: SimulationState) -> None:
        if not self._runs:
            self._runs = True
            self._emit(self.runs)
        self._emit(
            self.simulation_changed,
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

    def _on_loading(self, message: UInt8) -> None:
        self._emit(self.loading_changed, message.data)

    def _on_models(self, message: ModelList) -> None:
        self._emit(self.models_changed, models_of(message))

    def _on_topics(self, _: DebugTopicList) -> None:
        self._poll_now.set()  # models have come or gone, perhaps with their scans

    def _poll(self) -> None:
        """Polls the master, which does not notify of new topics."""
        master = rosgraph.Master(rospy.get_name())
        while not self._is_closed:
            self._poll_now.clear()
            try:
                displays = of_topics(master.getPublishedTopics(""), rospy.resolve_name("/tf"))
                published, subscribed, _ = master.getSystemState()
                world = _parameter(master, rospy.resolve_name(f"{_SERVER}/world_path"))
            except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
                pass  # there is no master now; the window shows that there is no server
            else:
                self._on_polled(displays, world)
                self._on_subscribed(subscribed, dict(published))
                self._on_published(published)
            self._poll_now.wait(_POLL_PERIOD)
            time.sleep(0.1)  # several models that are spawned together cause one poll

    def _on_polled(self, displays: List[Shown], world: Optional[str]) -> None:
        if displays != self._displays:
            self._displays = displays
            self._emit(self.displays_changed, displays)
        if world and world != self._world:
            self._world = world
            self._emit(self.world_changed, world)

    def _on_subscribed(
        self, subscribed: List[Tuple[str, List[str]]], published: Dict[str, List[str]]
    ) -> None:
        """Looks for subscribers to goals. rviz, which publishes goals, subscribes to show them."""
        goals = goal_topics(
            topic for topic, nodes in subscribed if {*nodes} - {*published.get(topic, ())}
        )
        if goals != self._navigation:
            self._navigation = goals
            self._emit(self.navigation_changed, goals)

    def _on_published(self, nodes_by_topic: List[Tuple[str, List[str]]]) -> None:
        own = rospy.get_name()
        publishers = {
            topic: sorted(node for node in nodes if node != own) for topic, nodes in nodes_by_topic
        }
        if publishers != self._publishers:
            self._publishers = publishers
            self._emit(self.publishers_changed, publishers)


def _message(response: Any) -> str:
    return str(response.message)


def _parameter(master: rosgraph.Master, name: str) -> Optional[str]:
    try:
        return str(master.getParam(name))
    except rosgraph.MasterError:  # it is not set
        return None

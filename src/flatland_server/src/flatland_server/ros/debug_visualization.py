"""The layers and models as marker arrays for rviz.

`~debug/layer/<name>` and `~debug/layer/<name>_3d` have the walls of a layer. `~debug/model/<name>`
is published at a rate of real time while it has subscribers and the model moves, for each new
subscriber, and once a second; it is latched while it has subscribers. `~debug/topics` is latched
and lists these topics without `~debug/`.

For a viewer that does not read that list, `~debug/layers` has the walls of all layers, and
`~debug/models` the markers of all moving models.
"""

import time
from typing import Dict, List

import rospy
from flatland_msgs.msg import DebugTopicList
from visualization_msgs.msg import MarkerArray

from flatland_server.messages.model_markers import ModelMarkers
from flatland_server.messages.serialized_markers import MarkerBytes, array_of, delete_all
from flatland_server.models.model import Model
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.ros.ros_transport import SubscriberCounter
from flatland_server.ros.rospy_patches import RospyCalls
from flatland_server.serving.map_to_odom import FRAME_ID
from flatland_server.serving.wall_visualization import WallVisualization
from flatland_server.simulation.world import World

_FULL_PERIOD = 1.0
"""Seconds of real time after which models at rest are published again."""

_AGAIN_DELAYS = (1.0, 3.0)
"""Seconds of real time after a jump of simulated time until walls are published again. rviz
discards all markers, latched ones too, when it notices that time went back: soon after /clock did,
unless the machine is busy."""

_DELETE_ALL = delete_all(FRAME_ID)


class DebugVisualization:
    """Publishes the markers of a world.

    Args:
        world: the world to show.
        rate: how often models are published [Hz of real time].
        rospy_calls: the operations of rospy to use.
    """

    def __init__(self, world: World, rate: float, rospy_calls: RospyCalls) -> None:
        self._world = world
        self._rospy_calls = rospy_calls
        self._timer = RealTimeTimer(1.0 / rate)
        self._next_full = 0.0
        self._walls_due: List[float] = []  # when they are published again
        self._subscribers = 0
        self._walls = WallVisualization(world.layers, FRAME_ID, world.transport)
        self._models: Dict[str, _ModelDisplay] = {}
        self._closing: List[_ModelDisplay] = []  # of deleted models
        self._topics = rospy.Publisher("~debug/topics", DebugTopicList, queue_size=1, latch=True)
        self._all = rospy.Publisher("~debug/models", MarkerArray, queue_size=1)
        self._follow_models()
        self._publish_topics()

    def update(self) -> None:
        """Publishes the markers that are due. To be called often, on the simulation's thread."""
        if not self._timer.check_update():
            return
        now = time.monotonic()
        while self._walls_due and now >= self._walls_due[0]:
            del self._walls_due[0]
            self._walls.publish_again()
        has_other_layers = self._walls.update(self._world.layers)
        while self._closing:
            self._closing.pop().close()
        has_changed = self._follow_models()
        if has_changed or has_other_layers:
            self._publish_topics()
        subscribers = self._all.get_num_connections()
        # Models at rest are published again for new subscribers only, and once a period.
        with_all = has_changed or subscribers > self._subscribers or now >= self._next_full
        self._subscribers = subscribers
        if with_all:
            self._next_full = now + _FULL_PERIOD
        markers = [_DELETE_ALL] if has_changed else []
        for display in self._models.values():
            display.count_subscribers()
            if (subscribers or display.has_subscribers) and display.place(with_all):
                markers.append(display.publish())
        if subscribers and markers:
            self._all.publish(array_of(markers))

    def time_has_jumped(self) -> None:
        """Publishes the walls again for viewers that discard all markers when time goes back."""
        now = time.monotonic()
        self._walls_due = [now + delay for delay in _AGAIN_DELAYS]

    def _follow_models(self) -> bool:
        """Adds displays of new models and removes those of deleted ones; returns whether any."""
        present = self._world.models
        gone = [
            name for name, shown in self._models.items() if present.get(name) is not shown.model
        ]
        new = [name for name in present if name not in self._models or name in gone]
        for name in gone:
            self._closing.append(self._models.pop(name))
            self._closing[-1].delete_markers()
        for name in new:
            self._models[name] = _ModelDisplay(present[name], self._rospy_calls)
        return bool(gone or new)

    def _publish_topics(self) -> None:
        models = [display.topic for display in self._models.values()]
        self._topics.publish([*self._walls.topics, *models])


class _ModelDisplay:
    def __init__(self, model: Model, rospy_calls: RospyCalls) -> None:
        self.model = model
        self.topic = f"model/{model.name}"
        self._forget_latched = rospy_calls.forget_latched
        self._counter = SubscriberCounter()
        self._publisher = rospy.Publisher(
            f"~debug/{self.topic}",
            MarkerArray,
            self._counter,
            queue_size=1,
            latch=self._forget_latched is not None,
        )
        self._subscribers = 0
        self._revision = 0
        self._markers = ModelMarkers(model, FRAME_ID)

    def count_subscribers(self) -> None:
        """Updates `has_subscribers`. Without any, nothing is published that could be latched."""
        had_subscribers = self.has_subscribers
        self._subscribers = self._publisher.get_num_connections()
        if had_subscribers and not self.has_subscribers and self._forget_latched is not None:
            self._forget_latched(self._publisher)

    @property
    def has_subscribers(self) -> bool:
        """True if this model's own topic has subscribers."""
        return self._subscribers > 0

    def place(self, is_full: bool) -> bool:
        """Updates the markers' poses. Returns whether to publish them.

        Args:
            is_full: whether to publish them even if the model is at rest.
        """
        has_other_subscribers = self._counter.revision != self._revision
        self._revision = self._counter.revision
        return self._markers.place() or is_full or has_other_subscribers

    def publish(self) -> MarkerBytes:
        """Returns the markers, and publishes them if the model's own topic has subscribers."""
        markers = self._markers.bytes()
        if self.has_subscribers:
            self._publisher.publish(array_of([markers]))
        return markers

    def delete_markers(self) -> None:
        """Makes rviz delete the markers."""
        self._publisher.publish(array_of([_DELETE_ALL]))
        if self._forget_latched is not None:
            # A new model of the same name has the same topic.
            self._forget_latched(self._publisher)

    def close(self) -> None:
        """Closes the topic; a while after the last message, which rospy may send later."""
        self._publisher.unregister()

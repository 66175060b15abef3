"""What rviz shows: the layers and models as marker arrays.

`~debug/layer/<name>` is latched, and published again if walls are added. `~debug/model/<name>` is
published at a rate of real time, while somebody listens and the model moves, and once a second.
`~debug/topics` is latched and lists them without `~debug/`. `~debug/models` has the markers of all
models that move, for a viewer that does not follow that list.
"""

import time
from typing import Dict

import rospy
from flatland_msgs.msg import DebugTopicList
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

from flatland_server.messages.model_markers import ModelMarkers
from flatland_server.messages.serialized_markers import MarkerBytes, array_of, serialized
from flatland_server.messages.wall_markers import wall_markers
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model
from flatland_server.ros.real_time_timer import RealTimeTimer
from flatland_server.simulation.world import World

FRAME_ID = "map"

_FULL_PERIOD = 1.0
"""Seconds of real time after which models that rest are published again."""

# With a frame, or rviz would not wait its turn behind the markers that it is to delete.
_DELETE_ALL = serialized([Marker(action=Marker.DELETEALL, header=Header(frame_id=FRAME_ID))])


class DebugVisualization:
    """Publishes the markers of a world.

    Args:
        world: what is shown.
        rate: how often models are published [Hz of real time].
    """

    def __init__(self, world: World, rate: float) -> None:
        self._world = world
        self._timer = RealTimeTimer(1.0 / rate)
        self._next_full = 0.0
        self._listeners = 0
        self._layers = [_LayerDisplay(layer) for layer in world.layers]
        self._models: Dict[str, _ModelDisplay] = {}
        self._topics = rospy.Publisher("~debug/topics", DebugTopicList, queue_size=1, latch=True)
        self._all = rospy.Publisher("~debug/models", MarkerArray, queue_size=1)
        self._follow_models()
        self._publish_topics()

    def update(self) -> None:
        """Publishes what is due. To be called often, on the simulation's thread."""
        if not self._timer.check_update():
            return
        now = time.monotonic()
        for layer in self._layers:
            layer.update()
        has_changed = self._follow_models()
        if has_changed:
            self._publish_topics()
        listeners = self._all.get_num_connections()
        # What rests need not be told of again, but to somebody who comes late.
        with_all = has_changed or listeners > self._listeners or now >= self._next_full
        self._listeners = listeners
        if with_all:
            self._next_full = now + _FULL_PERIOD
        markers = [_DELETE_ALL] if has_changed else []
        for display in self._models.values():
            if (listeners or display.has_subscribers) and display.place(with_all):
                markers.append(display.publish())
        if listeners and markers:
            self._all.publish(array_of(markers))

    def _follow_models(self) -> bool:
        """Makes displays for new models and ends those of models that are gone."""
        present = self._world.models
        gone = [
            name for name, shown in self._models.items() if present.get(name) is not shown.model
        ]
        new = [name for name in present if name not in self._models or name in gone]
        for name in gone:
            self._models.pop(name).close()
        for name in new:
            self._models[name] = _ModelDisplay(present[name])
        return bool(gone or new)

    def _publish_topics(self) -> None:
        self._topics.publish([display.topic for display in [*self._layers, *self._models.values()]])


class _LayerDisplay:
    def __init__(self, layer: Layer) -> None:
        self.topic = f"layer/{layer.name}"
        self._layer = layer
        self._publisher = rospy.Publisher(
            f"~debug/{self.topic}", MarkerArray, queue_size=1, latch=True
        )
        self._shown = -1
        self.update()

    def update(self) -> None:
        """Publishes the walls, if there are new ones."""
        if len(self._layer.segments) != self._shown:
            self._shown = len(self._layer.segments)
            self._publisher.publish(wall_markers(self._layer, FRAME_ID))


class _ModelDisplay:
    def __init__(self, model: Model) -> None:
        self.model = model
        self.topic = f"model/{model.name}"
        self._publisher = rospy.Publisher(f"~debug/{self.topic}", MarkerArray, queue_size=1)
        self._listeners = 0
        self._markers = ModelMarkers(model, FRAME_ID)

    @property
    def has_subscribers(self) -> bool:
        """Whether anybody listens to this model's own topic."""
        return self._publisher.get_num_connections() > 0

    def place(self, anyway: bool) -> bool:
        """Puts the markers where the model is. Returns whether to publish them: if it has moved."""
        listeners = self._publisher.get_num_connections()
        is_new_to_somebody = listeners > self._listeners
        self._listeners = listeners
        return self._markers.place() or anyway or is_new_to_somebody

    def publish(self) -> MarkerBytes:
        """The markers; publishes them, if anybody listens to this model."""
        markers = self._markers.bytes()
        if self._listeners:
            self._publisher.publish(array_of([markers]))
        return markers

    def close(self) -> None:
        """Makes rviz forget the model, and takes the topic away."""
        self._publisher.publish(array_of([_DELETE_ALL]))
        self._publisher.unregister()

"""The walls of layers as marker arrays for rviz, on latched topics.

They are serialized only for subscribers, and published again when walls are added.
"""

import logging
from typing import Callable, Dict, List

import rospy
from visualization_msgs.msg import MarkerArray

from flatland_server.arrays import Segments
from flatland_server.messages.serialized_markers import (
    LazyMarkerArray,
    MarkerBytes,
    array_of,
    delete_all,
)
from flatland_server.messages.wall_markers import flat_walls, upright_walls
from flatland_server.models.layer import Layer, LayerConfig

logger = logging.getLogger(__name__)


class WallVisualization:
    """Publishes the walls of all layers.

    For each name of a layer, `~debug/layer/<name>` has lines on the ground and
    `~debug/layer/<name>_3d` upright rectangles. `~debug/layers` has the lines of all layers, once.

    Args:
        layers: of the world.
        frame_id: of the world.
    """

    def __init__(self, layers: List[Layer], frame_id: str) -> None:
        self._layers = layers
        self._frame_id = frame_id
        self._shown: Dict[str, int] = {}
        self._all = _latched("layers")
        names = [name for layer in layers for name in layer.config.names]
        self._flat = {name: _latched(f"layer/{name}") for name in names}
        self._upright: Dict[str, rospy.Publisher] = {}
        self.topics: List[str] = []
        """The topics without `~debug/`, except `layers`."""
        for name in names:
            self.topics.append(f"layer/{name}")
            if f"{name}_3d" in names:
                logger.warning(
                    'the layer "%s" has no topic with upright walls: ~debug/layer/%s_3d is a topic '
                    'of the layer "%s_3d"',
                    *(name, name, name),
                )
                continue
            self._upright[name] = _latched(f"layer/{name}_3d")
            self.topics.append(f"layer/{name}_3d")
        self.update()

    def update(self) -> None:
        """Publishes the walls of layers that have new ones."""
        changed = [one for one in self._layers if len(one.segments) != self._shown.get(one.name)]
        for layer in changed:
            self._shown[layer.name] = len(layer.segments)
            flat, upright = self._message(flat_walls, layer), self._message(upright_walls, layer)
            for name in layer.config.names:
                self._flat[name].publish(flat)
                if name in self._upright:
                    self._upright[name].publish(upright)
        if changed:
            self._all.publish(self._of_all_layers())

    def _message(
        self, make: Callable[[LayerConfig, Segments, str], MarkerBytes], layer: Layer
    ) -> LazyMarkerArray:
        config, segments, frame_id = layer.config, layer.segments, self._frame_id
        return LazyMarkerArray(lambda: array_of([make(config, segments, frame_id)]))

    def _of_all_layers(self) -> LazyMarkerArray:
        walls = [(layer.config, layer.segments) for layer in self._layers]
        frame_id = self._frame_id

        def make() -> MarkerArray:
            # A viewer may still show the walls of another world.
            begin = delete_all(frame_id)
            return array_of([begin, *(flat_walls(*each, frame_id) for each in walls)])

        return LazyMarkerArray(make)


def _latched(topic: str) -> rospy.Publisher:
    return rospy.Publisher(f"~debug/{topic}", MarkerArray, queue_size=1, latch=True)

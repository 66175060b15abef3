"""The walls of layers on latched topics: marker arrays for rviz, and a smaller form for the window.

They are serialized only for subscribers, and published again when walls are added.
"""

import logging
from typing import Any, Callable, Dict, List, Tuple

import numpy as np

from flatland_server.arrays import Segments
from flatland_server.messages.message_types import get
from flatland_server.messages.serialized_markers import (
    DELETE_ALL,
    LazyMarkerArray,
    MarkerBytes,
    array_of,
)
from flatland_server.messages.wall_markers import flat_walls, upright_walls, walls_of
from flatland_server.models.layer import Layer, LayerConfig
from flatland_server.transport.transport import Publisher

MarkerArray = get("visualization_msgs/MarkerArray")
Walls = get("flatland_msgs/Walls")

logger = logging.getLogger(__name__)


class WallVisualization:
    """Publishes the walls of all layers.

    For each name of a layer, `~debug/layer/<name>` has lines on the ground and
    `~debug/layer/<name>_3d` upright rectangles. `~debug/layers` has the lines of all layers, once;
    `~debug/walls` has the same as flatland_msgs/Walls.

    Args:
        layers: those of the world.
        advertise: opens a latched topic, by its name without `~debug/`.
    """

    def __init__(self, layers: List[Layer], advertise: Callable[[str, Any], Publisher]) -> None:
        self._advertise = advertise
        self._layers: List[Layer] = []
        self._shown: Dict[str, Tuple[Layer, Segments]] = {}
        self._all = self._advertise("layers", MarkerArray)
        self._compact = self._advertise("walls", Walls)
        self._flat: Dict[str, Publisher] = {}
        self._upright: Dict[str, Publisher] = {}
        self.update(layers)

    @property
    def topics(self) -> List[str]:
        """The topics without `~debug/`, except `layers`."""
        topics = []
        for name in self._flat:
            topics.append(f"layer/{name}")
            if name in self._upright:
                topics.append(f"layer/{name}_3d")
        return topics

    def update(self, layers: List[Layer]) -> bool:
        """Publishes the walls of layers where they have changed.

        Args:
            layers: those of the world; new objects after it was reset or reloaded.

        Returns:
            Whether the topics have changed.
        """
        has_other_topics = layers is not self._layers and self._follow_names(layers)
        self._layers = layers
        changed = [layer for layer in layers if self._has_changed(layer)]
        for layer in changed:
            flat, upright = self._message(flat_walls, layer), self._message(upright_walls, layer)
            for name in layer.config.names:
                self._flat[name].publish(flat)
                if name in self._upright:
                    self._upright[name].publish(upright)
        if changed or has_other_topics:
            walls = [(layer.config, layer.segments) for layer in layers]
            self._all.publish(self._as_markers(walls))
            self._compact.publish(walls_of(walls))
        return has_other_topics

    def publish_again(self) -> None:
        """Makes the next `update` publish all walls, for viewers that have discarded them."""
        self._shown.clear()

    def _follow_names(self, layers: List[Layer]) -> bool:
        """Opens and closes topics if names of layers have changed; returns whether they have."""
        names = [name for layer in layers for name in layer.config.names]
        if names == list(self._flat):
            return False
        former = [*self._flat.values(), *self._upright.values()]
        for publisher in former:
            publisher.publish(array_of([DELETE_ALL]))
        self._flat = {name: self._advertise(f"layer/{name}", MarkerArray) for name in names}
        self._upright = {}
        for name in names:
            if f"{name}_3d" in names:
                logger.warning(
                    'the layer "%s" has no topic with upright walls: ~debug/layer/%s_3d is a topic '
                    'of the layer "%s_3d"',
                    *(name, name, name),
                )
            else:
                self._upright[name] = self._advertise(f"layer/{name}_3d", MarkerArray)
        for publisher in former:
            publisher.close()
        self._shown.clear()
        return True

    def _has_changed(self, layer: Layer) -> bool:
        """True if a layer has walls, a colour or heights that are not shown."""
        before, walls = self._shown.get(layer.name, (None, layer.segments))
        if before is layer and walls is layer.segments:
            return False
        self._shown[layer.name] = (layer, layer.segments)
        is_same = before is not None and before.config == layer.config
        return not (is_same and np.array_equal(walls, layer.segments))

    def _message(
        self, make: Callable[[LayerConfig, Segments], MarkerBytes], layer: Layer
    ) -> LazyMarkerArray:
        config, segments = layer.config, layer.segments
        return LazyMarkerArray(lambda: array_of([make(config, segments)]))

    def _as_markers(self, walls: List[Tuple[LayerConfig, Segments]]) -> LazyMarkerArray:
        # A viewer may still show the walls of another world.
        return LazyMarkerArray(
            lambda: array_of([DELETE_ALL, *(flat_walls(*each) for each in walls)])
        )

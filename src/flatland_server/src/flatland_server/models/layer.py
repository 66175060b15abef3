"""A layer: walls of the world that share a colour and collision layers.

A layer may have several names. Each of them is a collision layer; the first identifies the layer.
A layer without a map has no walls: it is a collision layer for footprints.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, List, Optional, Tuple, Union

import numpy as np

from flatland_server import _core
from flatland_server.arrays import Segments
from flatland_server.config.yaml_map import check_topic_name
from flatland_server.config.yaml_reader import Color, YamlReader
from flatland_server.exceptions import shortened
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.entity import Entities, Entity

_IMAGES = (".bmp", ".gif", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp")

MapSource = Union[Path, str]
"""A map file, or the place of a map in a world file, such as "layers[0].map"."""


@dataclass(frozen=True)
class LayerConfig:
    """An entry of a world's `layers`.

    Attributes:
        names: of the layer and its collision layers.
        bits: of all its names, together.
        color: its walls' color.
        min_z: lower edge of its upright walls in rviz [m].
        max_z: upper edge of its upright walls in rviz [m].
        map: its map file, or the place of the map in the world file; None without one.
        encloses: whether its walls are outlines of occupied areas: of a map image, or a grid.
    """

    names: Tuple[str, ...]
    bits: int
    color: Color
    min_z: float
    max_z: float
    map: Optional[MapSource]
    encloses: bool = False

    @classmethod
    def read(cls, reader: YamlReader, registry: CollisionFilterRegistry) -> "LayerConfig":
        """Reads an entry, and registers its names; does not read its map.

        Raises:
            YamlError: something in the entry is wrong.
        """
        names = reader.get_strings("name")
        if not names and reader.is_sound:
            reader.problem("expected a name or a list of names, found an empty list", "name")
        bits = 0
        for name in names:
            check_topic_name(reader, "name", name)
            try:
                bits |= registry.register(name)
            except ValueError as error:
                reader.problem(str(error), "name")
        color = reader.get_color("color", (1.0, 1.0, 1.0, 1.0))
        properties = reader.get_section("properties")
        debug = properties.get_section("debug")
        min_z = debug.get_float("min_z", 0.0)
        max_z = debug.get_float("max_z", 1.0)
        debug.finish()
        properties.finish()
        source = cls.read_map_source(reader)
        reader.finish()
        return cls(names, bits, color, min_z, max_z, source)

    @staticmethod
    def read_map_source(reader: YamlReader) -> Optional[MapSource]:
        """The map of an entry, if any; other problems of the entry are ignored."""
        if reader.is_map("map"):
            return reader.get_section("map").path
        name = reader.get_string("map", "")
        if name.lower().endswith(_IMAGES):
            message = f'expected a YAML file that names the image, found "{shortened(name)}"'
            reader.problem(message, "map")
            return None
        return reader.get_path("map") if reader.has("map") else None


class Layer(Entity):
    """A layer of a world.

    Args:
        config: the layer's entry in the world file.
        segments: its walls in the world [m]: shape (n, 4), x1, y1, x2, y2. It keeps this array.
        physics: physical world to add the layer to.
        entities: the entities of that world; the layer adds itself.
        progress: called with the number of walls added so far, now and then.
    """

    def __init__(
        self,
        config: LayerConfig,
        segments: Segments,
        physics: _core.World,
        entities: Entities,
        progress: Optional[Callable[[int], None]] = None,
    ) -> None:
        self.config = config
        self._physics = physics
        self._entities = entities
        self._bodies: List[_core.Body] = []
        self._segments = segments
        self._add_bodies(segments, progress)

    @property
    def name(self) -> str:
        """The name that identifies it."""
        return self.config.names[0]

    @property
    def segments(self) -> Segments:
        """Its walls in the world [m]: shape (n, 4), x1, y1, x2, y2."""
        return self._segments

    @property
    def physics_bodies(self) -> List[_core.Body]:
        return list(self._bodies)

    def body_name(self, fixture: _core.Fixture) -> str:
        return self.name

    def add_walls(self, segments: Segments) -> None:
        """Adds walls; plugins call `World.add_walls`.

        Args:
            segments: in the world [m]: shape (n, 4), x1, y1, x2, y2.

        Raises:
            ValueError: a segment is not finite, or of no length.
        """
        self._add_bodies(segments)
        self._segments = np.concatenate([self._segments, segments])

    def _add_bodies(
        self, segments: Segments, progress: Optional[Callable[[int], None]] = None
    ) -> None:
        if len(segments) == 0:
            return
        body = self._physics.add_layer(segments, self.config.bits, progress)
        self._bodies.append(body)
        self._entities.add(self, [body])

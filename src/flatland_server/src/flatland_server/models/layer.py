"""A layer: the walls of the world, from a map image or from line segments.

A layer may have several names, which all count as collision layers; the first identifies it. A
layer without a map is a name that footprints can use, and nothing else.
"""

import logging
from dataclasses import dataclass, field
from pathlib import Path
from typing import List, Optional, Tuple

import numpy as np
from PIL import Image, UnidentifiedImageError

from flatland_server import _core
from flatland_server.arrays import Segments
from flatland_server.config.ros_names import check_topic_name
from flatland_server.config.yaml_preprocessor import YamlPreprocessor, is_file
from flatland_server.config.yaml_reader import Color, YamlReader
from flatland_server.exceptions import YamlError
from flatland_server.geometry import Pose
from flatland_server.maps.simplify_outlines import TOLERANCES, simplify
from flatland_server.maps.slow_log import log_if_slow
from flatland_server.maps.wall_outlines import bright_pixels, outlines
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.entity import Entities, Entity

logger = logging.getLogger(__name__)

_FARTHEST = 1e5  # m; the core takes no more
_SHORTEST = 1e-6  # m; a wall of less is nothing to a laser or a body


@dataclass(frozen=True)
class LayerConfig:
    """An entry of a world's `layers`, with its walls."""

    names: Tuple[str, ...]
    bits: int
    color: Color
    min_z: float
    max_z: float
    segments: Segments = field(repr=False, compare=False)

    @classmethod
    def read(
        cls,
        reader: YamlReader,
        registry: CollisionFilterRegistry,
        preprocessor: Optional[YamlPreprocessor] = None,
        simplify_map: int = 0,
    ) -> "LayerConfig":
        """Reads the entry and its map, and registers its names.

        Args:
            reader: the entry.
            registry: of the world's layers.
            preprocessor: has the parameters for the map file's expressions.
            simplify_map: how much the outlines of images are simplified; see `read_map`.

        Raises:
            YamlError: something in the entry or its files is wrong.
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
        max_z = debug.get_float("max_z", 0.0)
        debug.finish()
        properties.finish()
        segments: Segments = np.empty((0, 4))
        if reader.has("map"):
            path = reader.get_path("map")
            if is_file(path):
                try:
                    segments = read_map(path, preprocessor, simplify_map)
                except YamlError as error:
                    reader.note(error)
        reader.get_string("map", "")
        reader.finish()
        return cls(names, bits, color, min_z, max_z, segments)


class Layer(Entity):
    """A layer of a world.

    Args:
        config: what its file says.
        physics: the world it is put in.
        entities: who has a part in that world's contacts.
    """

    def __init__(self, config: LayerConfig, physics: _core.World, entities: Entities) -> None:
        self.config = config
        self._physics = physics
        self._entities = entities
        self._bodies: List[_core.Body] = []
        self._segments: Segments = np.empty((0, 4))
        self.add_walls(config.segments)

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
        """Puts up walls [m], of the same shape as `segments`; `World.add_walls` is for plugins.

        Raises:
            ValueError: one is not finite, or of no length.
        """
        if len(segments) == 0:
            return
        body = self._physics.add_layer(segments, self.config.bits)
        self._bodies.append(body)
        self._entities.add(self, [body])
        self._segments = np.concatenate([self._segments, segments])


def read_map(
    path: Path, preprocessor: Optional[YamlPreprocessor] = None, simplify_map: int = 0
) -> Segments:
    """The walls [m] that a map's YAML file describes: shape (n, 4), x1, y1, x2, y2.

    Args:
        path: of a map_server or a line segments file.
        preprocessor: has the parameters for the file's expressions.
        simplify_map: an index of `simplify_outlines.TOLERANCES`; 0 leaves outlines as they are.

    Raises:
        YamlError: something in the file, or in the image or data that it names, is wrong.
    """
    reader = YamlReader.from_file(path, preprocessor)
    origin = reader.get_pose("origin")
    is_lines = reader.get_choice("type", ["image", "line_segments"], "image") == "line_segments"
    if is_lines:
        scale = reader.get_float("scale", above=0.0)
        source = reader.get_path("data")
    else:
        scale = reader.get_float("resolution", above=0.0)
        occupied_thresh = reader.get_float("occupied_thresh")
        for unused in ("free_thresh", "negate", "mode"):
            reader.get_string(unused, "")
        source = reader.get_path("image")
    reader.finish()
    with log_if_slow(f"{path}: reading walls takes a while ..."):
        segments = _read_line_segments(source) if is_lines else _read_image(source, occupied_thresh)
    if simplify_map and not is_lines:
        before, tolerance = len(segments), TOLERANCES[simplify_map]
        with log_if_slow(f"{path}: simplifying {before} segments takes a while ..."):
            segments = simplify(segments, tolerance)
        logger.info(
            "%s: outlines simplified from %d to %d segments, within %g m",
            *(path, before, len(segments), tolerance * scale),
        )
    segments = _place(segments * scale, origin)
    if len(segments) and np.abs(segments).max() > _FARTHEST:
        raise YamlError(path, "expected walls within 100 km of the origin, found one beyond")
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    if len(segments) and lengths.min() < _SHORTEST:
        raise YamlError(path, "expected walls of a micrometre or more, found a shorter one")
    return segments


def _read_image(path: Path, occupied_thresh: float) -> Segments:
    try:
        with Image.open(path) as image:
            return outlines(bright_pixels(image, occupied_thresh))
    except UnidentifiedImageError:
        raise YamlError(path, "is not an image of a known format") from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise YamlError(path, f"cannot be read as an image: {reason}") from None


def _read_line_segments(path: Path) -> Segments:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise YamlError(path, f"cannot be read: {reason}") from None
    rows = []
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            row = [float(word) for word in line.split()]
        except ValueError:
            row = []
        if len(row) != 4 or not np.isfinite(row).all():
            raise YamlError(path, f'expected "x1 y1 x2 y2", found "{line.strip()[:60]}"', number)
        if row[:2] == row[2:]:
            raise YamlError(path, "expected two different ends, found one point twice", number)
        rows.append(row)
    return np.array(rows, dtype=np.float64).reshape(-1, 4)


def _place(segments: Segments, origin: Pose) -> Segments:
    """Turns and moves segments from the map's frame to the world's."""
    cos, sin = np.cos(origin.yaw), np.sin(origin.yaw)
    turn = np.array([[cos, sin], [-sin, cos]])
    points = segments.reshape(-1, 2) @ turn + np.array([origin.x, origin.y])
    return np.asarray(points.reshape(-1, 4))

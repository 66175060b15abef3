"""Reads map files: walls from images, in the format of map_server, and from line segments."""

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

import numpy as np
from PIL import Image, UnidentifiedImageError

from flatland_server.arrays import Segments
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import YamlError
from flatland_server.geometry import Pose
from flatland_server.maps.simplify_outlines import TOLERANCES, simplify
from flatland_server.maps.slow_log import log_if_slow
from flatland_server.maps.wall_outlines import bright_pixels, outlines

logger = logging.getLogger(__name__)

_FARTHEST = 1e5  # m from the origin of the world; the limit of the core
_SHORTEST = 1e-6  # m; shorter walls are lost to rounding


@dataclass(frozen=True)
class MapConfig:
    """A map's YAML file.

    Attributes:
        path: the YAML file.
        source: the image, or the file of line segments.
        is_image: whether `source` is an image.
        scale: metres per pixel of an image, or per unit of line segments.
        origin: pose of the image's bottom left corner, or of the origin of the line segments, in
            the world.
        occupied_thresh: grey value between 0 (black) and 1 (white) above which a pixel is bright.
    """

    path: Path
    source: Path
    is_image: bool
    scale: float
    origin: Pose
    occupied_thresh: float = 0.0

    @classmethod
    def from_file(cls, path: Path, preprocessor: Optional[YamlPreprocessor] = None) -> "MapConfig":
        """Reads the YAML file, but not the file of the walls that it names.

        Args:
            path: of the file.
            preprocessor: has the parameters for the file's expressions.

        Raises:
            YamlError: something in the file is wrong.
        """
        reader = YamlReader.from_file(path, preprocessor)
        origin = reader.get_pose("origin")
        if reader.get_choice("type", ["image", "line_segments"], "image") == "line_segments":
            scale = reader.get_float("scale", above=0.0)
            source = reader.get_path("data")
            reader.finish()
            return cls(path, source, False, scale, origin)
        scale = reader.get_float("resolution", above=0.0)
        occupied_thresh = reader.get_float("occupied_thresh")
        for unused in ("free_thresh", "negate", "mode"):
            reader.get_string(unused, "")
        source = reader.get_path("image")
        reader.finish()
        return cls(path, source, True, scale, origin, occupied_thresh)


def read_map(
    path: Path, preprocessor: Optional[YamlPreprocessor] = None, simplify_map: int = 0
) -> Segments:
    """The walls of a map, in the world.

    Args:
        path: of the map's YAML file.
        preprocessor: has the parameters for the file's expressions.
        simplify_map: how much outlines of images are simplified: an index of
            `simplify_outlines.TOLERANCES`; 0 leaves them as they are.

    Returns:
        Wall segments [m]: shape (n, 4), x1, y1, x2, y2.

    Raises:
        YamlError: something in the file, or in the image or data that it names, is wrong.
    """
    config = MapConfig.from_file(path, preprocessor)
    with log_if_slow(f"{path}: reading walls takes a while ..."):
        if config.is_image:
            segments = _read_image(config.source, config.occupied_thresh)
        else:
            segments = _read_line_segments(config.source)
    if simplify_map and config.is_image:
        segments = _simplified(segments, config, TOLERANCES[simplify_map])
    segments = _place(segments * config.scale, config.origin)
    _check(segments, path)
    return segments


def _read_image(path: Path, occupied_thresh: float) -> Segments:
    """The outlines of an image, in pixels from its bottom left corner."""
    try:
        with Image.open(path) as image:
            return outlines(bright_pixels(image, occupied_thresh))
    except UnidentifiedImageError:
        raise YamlError(path, "is not an image of a known format") from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise YamlError(path, f"cannot be read as an image: {reason}") from None


def _read_line_segments(path: Path) -> Segments:
    """The segments of a text file with a line `x1 y1 x2 y2` for each, in the file's unit."""
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


def _simplified(segments: Segments, config: MapConfig, tolerance: float) -> Segments:
    """Outlines [px] with fewer segments, and a line in the log that says how many."""
    before = len(segments)
    with log_if_slow(f"{config.path}: simplifying {before} segments takes a while ..."):
        simplified = simplify(segments, tolerance)
    logger.info(
        "%s: outlines simplified from %d to %d segments, within %g m",
        config.path,
        before,
        len(simplified),
        tolerance * config.scale,
    )
    return simplified


def _place(segments: Segments, origin: Pose) -> Segments:
    """Transforms segments from the map's frame to the world's."""
    cos, sin = np.cos(origin.yaw), np.sin(origin.yaw)
    rotation = np.array([[cos, sin], [-sin, cos]])  # transposed: points are rows
    points = segments.reshape(-1, 2) @ rotation + np.array([origin.x, origin.y])
    return np.asarray(points.reshape(-1, 4))


def _check(segments: Segments, path: Path) -> None:
    """Refuses walls that physics cannot represent."""
    if len(segments) == 0:
        return
    if np.abs(segments).max() > _FARTHEST:
        raise YamlError(path, "expected walls within 100 km of the origin, found one beyond")
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    if lengths.min() < _SHORTEST:
        raise YamlError(path, "expected walls of a micrometre or more, found a shorter one")

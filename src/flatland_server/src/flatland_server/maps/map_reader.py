"""Reads map files: walls from images, in the format of map_server, and from line segments."""

import io
import logging
import math
import warnings
from array import array
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Callable, Optional, Tuple

import numpy as np

from flatland_server.arrays import BoolArray, IntArray, Segments
from flatland_server.config.input_files import MAX_IMAGE, MAX_LINE_SEGMENTS, read_input
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.config.yaml_values import LARGEST
from flatland_server.exceptions import YamlError, shortened, suggestion
from flatland_server.geometry import Pose
from flatland_server.maps.simplify_outlines import TOLERANCES, simplify
from flatland_server.maps.slow_log import log_if_slow
from flatland_server.maps.wall_outlines import bright_pixels, outlines

if TYPE_CHECKING:  # Pillow is imported when an image is read
    from PIL import Image

logger = logging.getLogger(__name__)

_LINES = "line_segments"
"""The `type` of a map of line segments; every other one is an image."""

_FARTHEST = 1e5  # m from the origin of the world; the limit of the core
_SHORTEST = 1e-6  # m; shorter walls are lost to rounding

# Formats that Pillow decodes by itself: for EPS it would start Ghostscript.
# Pillow imports all it knows, 30 formats, when it tries one besides the first five.
_FORMATS = ("BMP", "GIF", "JPEG", "PNG", "PPM", "PCX", "TGA", "TIFF", "WEBP")
_MAX_PIXELS = 80_000_000  # less than a gigabyte while outlines are computed


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
        kind = reader.get_string("type", "image")
        if kind == _LINES:
            scale = reader.get_float("scale", above=0.0)
            source = reader.get_path("data")
            reader.finish()
            return cls(path, source, False, scale, origin)
        if suggestion(kind, [_LINES]):
            logger.info('%s: read as an image: expected "%s", found "%s"', path, _LINES, kind)
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
        Wall segments [m]: shape (n, 4), x1, y1, x2, y2. Read-only.

    Raises:
        YamlError: something in the file, or in the image or data that it names, is wrong.
    """
    config = MapConfig.from_file(path, preprocessor)
    lines = None
    with log_if_slow(f"{path}: reading walls takes a while ..."):
        if config.is_image:
            segments = read_image(
                config.source, lambda image: bright_pixels(image, config.occupied_thresh)
            )
        else:
            segments, lines = _read_line_segments(config.source)
    if simplify_map and config.is_image:
        segments = _simplified(segments, config, TOLERANCES[simplify_map])
    segments *= config.scale
    segments = place(segments, config.origin)
    _check(segments, config, lines)
    segments.flags.writeable = False
    return segments


def read_image(path: Path, is_bright: Callable[["Image.Image"], BoolArray]) -> Segments:
    """The outlines of an image, in pixels from its bottom left corner.

    Args:
        path: of the image.
        is_bright: returns the mask of bright pixels: shape (height, width), the top row first.

    Returns:
        Shape (n, 4), x1, y1, x2, y2.

    Raises:
        YamlError: it cannot be read.
    """
    from PIL import Image, UnidentifiedImageError

    content = io.BytesIO(read_input(path, MAX_IMAGE))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image = Image.open(content, formats=_FORMATS)
        with image:
            if image.width * image.height > _MAX_PIXELS:
                raise Image.DecompressionBombError
            return outlines(is_bright(image))
    except UnidentifiedImageError:
        formats = ", ".join(_FORMATS)
        raise YamlError(path, f"is not an image of a known format: {formats}") from None
    except Image.DecompressionBombError:
        limit = f"{_MAX_PIXELS // 1_000_000} million pixels"
        raise YamlError(path, f"expected an image of at most {limit}, found more") from None
    except Exception as error:  # Pillow's decoders may raise anything on a faulty file
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise YamlError(path, f"cannot be read as an image: {shortened(reason)}") from None


def _read_line_segments(path: Path) -> Tuple[Segments, IntArray]:
    """The segments of a text file with a line `x1 y1 x2 y2` for each, in the file's unit.

    `#` begins a comment.

    Returns:
        Segments: shape (n, 4). The numbers of their lines, from 1: shape (n,).
    """
    try:
        lines = read_input(path, MAX_LINE_SEGMENTS).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise YamlError(path, "cannot be read: it is not UTF-8 text") from None
    values = array("d")
    numbers = array("q")
    for number, line in enumerate(lines, start=1):
        line = line.partition("#")[0].strip()
        if not line:
            continue
        try:
            row = [float(word) for word in line.split()]
        except ValueError:
            row = []
        if len(row) != 4 or not all(map(math.isfinite, row)):
            message = f'expected "x1 y1 x2 y2", found "{shortened(line)}"'
            raise YamlError(path, message, number)
        if max(map(abs, row)) > LARGEST:
            message = f'expected numbers within {LARGEST:g} of zero, found "{shortened(line)}"'
            raise YamlError(path, message, number)
        if row[:2] == row[2:]:
            raise YamlError(path, "expected two different ends, found one point twice", number)
        values.extend(row)
        numbers.append(number)
    return np.array(values, dtype=np.float64).reshape(-1, 4), np.array(numbers, dtype=np.intp)


def _simplified(segments: Segments, config: MapConfig, tolerance: float) -> Segments:
    """Outlines [px] with fewer segments; logs their number."""
    before = len(segments)
    with log_if_slow(f"{config.path}: simplifying {before} segments takes a while ..."):
        simplified = simplify(segments, tolerance).segments
    logger.info(
        "%s: outlines simplified from %d to %d segments, within %g m",
        config.path,
        before,
        len(simplified),
        tolerance * config.scale,
    )
    return simplified


def place(segments: Segments, origin: Pose) -> Segments:
    """Transforms segments from the map's frame to the world's."""
    cos, sin = np.cos(origin.yaw), np.sin(origin.yaw)
    rotation = np.array([[cos, sin], [-sin, cos]])  # transposed: points are rows
    points = segments.reshape(-1, 2) @ rotation
    points += np.array([origin.x, origin.y])
    return np.asarray(points.reshape(-1, 4))


def _check(segments: Segments, config: MapConfig, lines: Optional[IntArray]) -> None:
    """Refuses walls that physics cannot represent.

    Args:
        segments: in the world [m].
        config: the map that they are from.
        lines: the line of each in the file of line segments, if they are from one.
    """
    if len(segments) == 0:
        return

    def refuse(index: int, expected: str, found: str) -> None:
        place = "" if lines is None else f" in {config.source}:{lines[index]}"
        raise YamlError(config.path, f"expected walls {expected}, found {found}{place}")

    if max(segments.max(), -segments.min()) > _FARTHEST:
        farthest = int(np.abs(segments).max(axis=1).argmax())
        refuse(farthest, "within 100 km of the origin", "one beyond")
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    if lengths.min() < _SHORTEST:
        refuse(int(lengths.argmin()), "of a micrometre or more", "a shorter one")

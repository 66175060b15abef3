"""Reads maps: walls from images, in the format of map_server, from grids, and from line segments.

A map is a file, or a section of a world file, which has its walls in itself.
"""

import io
import logging
import math
import threading
import warnings
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, Optional, Tuple, TypeVar

import numpy as np

from flatland_server.arrays import BoolArray, FloatArray, IntArray, Segments
from flatland_server.config.input_files import MAX_IMAGE, read_input
from flatland_server.config.yaml_map import warn_once
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import YamlError, counted, shortened, suggestion
from flatland_server.geometry import Pose
from flatland_server.maps.line_data import read_line_segments
from flatland_server.maps.simplify_outlines import TOLERANCES, simplify
from flatland_server.maps.wall_outlines import bright_pixels, outlines, transparent_pixels

if TYPE_CHECKING:  # Pillow is imported when an image is read
    from PIL import Image

logger = logging.getLogger(__name__)

T = TypeVar("T")

DELAY = 2.0
"""Real time after which slow operations are logged [s]."""

INLINE = ("segments", "polygons", "circles", "grid")
"""The keys of walls that are in the map itself."""

_CIRCLE_SIDES = 36  # as those of a footprint's outline

_LINES = "line_segments"
"""The `type` of a map of line segments; every other one is an image."""

_LARGEST_CELL = 1.0  # m; a greater one, or a larger world, is a warning
_LARGEST_WORLD = 5000.0  # m
_FARTHEST = 1e5  # m from the origin of the world; the limit of the core
_SHORTEST = 1e-6  # m; shorter walls are lost to rounding: no walls

# Formats that Pillow decodes by itself: for EPS it would start Ghostscript.
# Pillow imports all it knows, 30 formats, when it tries one besides the first five.
_FORMATS = ("BMP", "GIF", "JPEG", "PNG", "PPM", "PCX", "TGA", "TIFF", "WEBP")
_ORIENTATION = 0x0112  # the tag of EXIF
_MAX_PIXELS = 80_000_000  # less than a gigabyte while outlines are computed


@dataclass(frozen=True)
class MapConfig:
    """A map's YAML file, or the map in a world file.

    Attributes:
        path: the YAML file.
        source: the image, or the file of line segments; None if the map has its walls in itself.
        scale: metres per pixel of an image or a grid, or per unit of line segments.
        origin: pose of the bottom left corner of the image or the grid, or of the origin of the
            line segments, in the world.
        occupied_thresh: grey value between 0 (black) and 1 (white) above which a pixel is bright.
        bright: the free cells of a grid, the top row first; None without a grid.
        lines: line segments that are in the map itself; None if `source` has them.
        is_image: whether it is an image or a grid.
        place: of the map in a world file, such as "layers[0].map".
        reader: of the file or the section, for warnings.
    """

    path: Path
    source: Optional[Path]
    scale: float
    origin: Pose
    occupied_thresh: float = 0.0
    bright: Optional[BoolArray] = None
    lines: Optional[Segments] = None
    is_image: bool = False
    place: str = ""
    reader: Optional[YamlReader] = field(default=None, compare=False, repr=False)

    @classmethod
    def from_file(cls, path: Path, preprocessor: Optional[YamlPreprocessor] = None) -> "MapConfig":
        """Reads the YAML file, but not the file of the walls that it names.

        Args:
            path: path of the map's YAML file.
            preprocessor: evaluates the file's expressions, with their parameters.

        Raises:
            YamlError: something in the file is wrong.
        """
        reader = YamlReader.from_file(path, preprocessor)
        if any(map(reader.has, INLINE)):
            return cls.read(reader)
        origin = reader.get_pose("origin")
        kind = reader.get_string("type", "image")
        if kind == _LINES:
            scale = reader.get_float("scale", above=0.0)
            source = reader.get_path("data")
            reader.finish()
            return cls(path, source, scale, origin, reader=reader)
        if suggestion(kind, [_LINES]):
            if not reader.has("image"):
                raise reader.error(f'expected "{_LINES}" or an image, found "{kind}"', "type")
            logger.info('%s: read as an image: expected "%s", found "%s"', path, _LINES, kind)
        scale = reader.get_float("resolution", above=0.0)
        occupied_thresh = read_threshold(reader)
        for unused in ("free_thresh", "negate", "mode"):
            reader.get_string(unused, "")
        source = reader.get_path("image")
        reader.finish()
        if scale > _LARGEST_CELL:
            reader.warn(f"expected metres per pixel, found {scale:g}", "resolution")
        return cls(path, source, scale, origin, occupied_thresh, is_image=True, reader=reader)

    @classmethod
    def read(cls, reader: YamlReader) -> "MapConfig":
        """Reads a map that has its walls in itself.

        Raises:
            YamlError: something in it is wrong.
        """
        origin = reader.get_pose("origin", Pose())
        if reader.has("grid"):
            scale = reader.get_float("resolution", above=0.0)
            occupied_thresh = reader.get_float("occupied_thresh", 0.0)
            bright = ~(reader.get_cells("grid")[::-1] > occupied_thresh)
            if bright.size > _MAX_PIXELS:
                reader.problem(f"expected at most {_MAX_PIXELS // 1_000_000} million cells", "grid")
            reader.finish()
            reader.raise_problems()
            return cls(
                reader.file,
                None,
                scale,
                origin,
                0.0,
                bright,
                is_image=True,
                place=reader.path,
                reader=reader,
            )
        if not any(map(reader.has, INLINE)):
            names = ", ".join(f'"{name}"' for name in INLINE)
            reader.problem(f"expected a file, or one of {names}; found none of these")
        scale = reader.get_float("scale", 1.0, above=0.0)
        outlines = reader.get_outlines("polygons")
        circles = reader.get_rows("circles", "[x, y, radius]", np.empty((0, 3)))
        for number in np.flatnonzero(circles[:, 2] <= 0.0)[:1]:
            reader.problem(f"expected a radius above 0 in circles[{number}]", "circles")
        outlines += [_circle(*circle) for circle in circles.tolist()]
        lines = [
            reader.get_rows("segments", "[x1, y1, x2, y2]", np.empty((0, 4))),
            *(np.hstack([outline, np.roll(outline, -1, axis=0)]) for outline in outlines),
        ]
        reader.finish()
        reader.raise_problems()
        walls = np.concatenate(lines)
        return cls(reader.file, None, scale, origin, lines=walls, place=reader.path, reader=reader)

    def content(self) -> Dict[str, Any]:
        """The map with its walls in itself, as `read` takes it; its grid or segments are arrays.

        Raises:
            YamlError: the image or the data cannot be read.
        """
        origin = list(self.origin)
        if self.is_image:
            return {"grid": ~self._bright()[::-1], "resolution": self.scale, "origin": origin}
        return {"segments": self._lines()[0], "scale": self.scale, "origin": origin}

    def walls(self, simplify_map: int = 0) -> Segments:
        """The walls of the map, in the world.

        Args:
            simplify_map: how much outlines of images are simplified: an index of
                `simplify_outlines.TOLERANCES`; 0 leaves them as they are.

        Returns:
            Wall segments [m]: shape (n, 4), x1, y1, x2, y2. Read-only.

        Raises:
            YamlError: something in the image or the data is wrong.
        """
        numbers = None
        with log_if_slow(f"{self.path}: reading walls takes a while ..."):
            if self.is_image:
                segments = outlines(self._bright())
            else:
                segments, numbers = self._lines()
        if simplify_map and self.is_image:
            segments = _simplified(segments, self, TOLERANCES[simplify_map])
        segments = place(segments * self.scale, self.origin)
        segments = _checked(segments, self, numbers)
        size = np.ptp(segments.reshape(-1, 2), axis=0).max() if len(segments) else 0.0
        if size > _LARGEST_WORLD:
            key = "resolution" if self.is_image else "scale"
            self._warn(f"expected a map of at most {_LARGEST_WORLD:g} m, found {size:.4g} m", key)
        segments.flags.writeable = False
        return segments

    def _warn(self, message: str, key: str) -> None:
        if self.reader is not None:
            self.reader.warn(message, key)

    def _bright(self) -> BoolArray:
        if self.bright is not None:
            return self.bright
        assert self.source is not None
        return read_image(self.source, self._bright_pixels)

    def _bright_pixels(self, image: "Image.Image") -> BoolArray:
        bright = bright_pixels(image, self.occupied_thresh)
        if self.occupied_thresh >= 1.0:
            return bright  # there was a warning
        hidden = transparent_pixels(image)
        if hidden is not None and (hidden & ~bright).any():
            self._warn("has dark transparent pixels, which are walls: alpha is ignored", "image")
        elif image.mode == "F" and np.asarray(image).max() <= 1.0:
            self._warn("expected grey values up to 255, found floats up to 1", "image")
        elif not bright.any():
            self._warn("has no pixel brighter than occupied_thresh: it is one block", "image")
        return bright

    def _lines(self) -> Tuple[Segments, Optional[IntArray]]:
        if self.source is None:
            assert self.lines is not None
            return self.lines, None
        return read_line_segments(self.source)


@contextmanager
def log_if_slow(message: str) -> Iterator[None]:
    """Logs a message if the block is still running after `DELAY`: it might be taken for hung."""
    timer = threading.Timer(DELAY, logger.info, (message,))
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def read_image(path: Path, to_pixels: Callable[["Image.Image"], T]) -> T:
    """The pixels of an image.

    Args:
        path: path of the image.
        to_pixels: returns the pixels of the upright image.

    Returns:
        What `to_pixels` returns.

    Raises:
        YamlError: it cannot be read.
    """
    from PIL import Image, UnidentifiedImageError

    content = io.BytesIO(read_input(path, MAX_IMAGE))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow's; ours are logged
            with Image.open(content, formats=_FORMATS) as image:
                if image.width * image.height > _MAX_PIXELS:
                    raise Image.DecompressionBombError
                return to_pixels(_upright(image))
    except UnidentifiedImageError:
        formats = ", ".join(_FORMATS)
        raise YamlError(path, f"is not an image of a known format: {formats}") from None
    except Image.DecompressionBombError:
        limit = f"{_MAX_PIXELS // 1_000_000} million pixels"
        raise YamlError(path, f"expected an image of at most {limit}, found more") from None
    except Exception as error:  # Pillow's decoders may raise anything on a faulty file
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise YamlError(path, f"cannot be read as an image: {shortened(reason)}") from None


def _upright(image: "Image.Image") -> "Image.Image":
    """An image turned as its EXIF data say; OpenCV, and so the original, does this, too."""
    from PIL import ImageOps

    image.load()  # some formats have these data at their end
    try:
        is_turned = image.getexif().get(_ORIENTATION, 1) != 1
        return ImageOps.exif_transpose(image) if is_turned else image
    except Exception:  # the image may be read nevertheless
        return image


def read_threshold(reader: YamlReader) -> float:
    """The `occupied_thresh` of an image, with a warning if all of it is on one side of it."""
    threshold = reader.get_float("occupied_thresh")
    if reader.is_sound and not 0.0 <= threshold < 1.0:
        message = f"expected a fraction from 0 to 1 (below 1), found {threshold:g}"
        reader.warn(message, "occupied_thresh")
    return threshold


def _circle(x: float, y: float, radius: float) -> FloatArray:
    """The corners of a regular polygon that approximates a circle: shape (k, 2)."""
    angles = np.arange(_CIRCLE_SIDES) * (math.tau / _CIRCLE_SIDES)
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


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


def _checked(segments: Segments, config: MapConfig, lines: Optional[IntArray]) -> Segments:
    """Walls without those that have no length; refuses those that physics cannot represent.

    Args:
        segments: in the world [m].
        config: the map with these walls, for errors.
        lines: the line of each in the file of line segments, if they are from one.
    """
    if len(segments) == 0:
        return segments

    def error(index: int, expected: str, found: str) -> YamlError:
        where = "" if lines is None else f" in {config.source}:{lines[index]}"
        if config.lines is not None:
            where = f": {[round(each, 9) for each in segments[index].tolist()]}"
        label = f"{config.place}: " if config.place else ""
        return YamlError(config.path, f"{label}expected walls {expected}, found {found}{where}")

    if max(segments.max(), -segments.min()) > _FARTHEST:
        farthest = int(np.abs(segments).max(axis=1).argmax())
        raise error(farthest, "within 100 km of the origin", "one beyond")
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    shorter = np.flatnonzero(lengths < _SHORTEST)
    if len(shorter) == 0:
        return segments
    if lines is None or len(shorter) == len(segments):  # the original reads such lines of files
        raise error(int(lengths.argmin()), "of a micrometre or more", "a shorter one")
    found = f"{counted(len(shorter), 'shorter one')}, left out, the first"
    warn_once(str(error(int(shorter[0]), "of a micrometre or more", found)))
    return np.delete(segments, shorter, axis=0)

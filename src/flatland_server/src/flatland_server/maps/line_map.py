"""Reads maps as map_server does: for its OccupancyGrid, and to make line segments of them.

An image layer compares grey values with a threshold alone; here map_server's parameters apply:
`negate`, `occupied_thresh` and `mode` (http://wiki.ros.org/map_server, section 1.2).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from flatland_server.arrays import BoolArray, FloatArray, Int8Array, Segments
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import FlatlandError, YamlError
from flatland_server.geometry import Pose
from flatland_server.maps import wall_outlines
from flatland_server.maps.map_reader import place, read_image, read_threshold
from flatland_server.maps.simplify_outlines import simplify

_FREE = 0.25
"""The default of `free_thresh`, that of Nav2."""
_FREE_CELL, _OCCUPIED, _UNKNOWN = 0, 100, -1

if TYPE_CHECKING:  # Pillow is imported when an image is read
    from PIL import Image


@dataclass(frozen=True)
class ServerMap:
    """A map's YAML file as map_server reads it.

    Attributes:
        path: the YAML file.
        image: the image.
        resolution: [m/px].
        origin: pose of the image's bottom left corner in the world.
        occupied_thresh: the occupancy, from 0 to 1, above which a pixel is a wall.
        free_thresh: the occupancy below which a pixel is free.
        negate: whether white is occupied, instead of black.
        is_scaled: whether pixels between free and occupied have a percentage: `mode: scale`.
    """

    path: Path
    image: Path
    resolution: float
    origin: Pose
    occupied_thresh: float
    free_thresh: float
    negate: bool
    is_scaled: bool

    @classmethod
    def from_file(cls, path: Path) -> "ServerMap":
        """Reads the YAML file.

        Raises:
            YamlError: something in it is wrong.
        """
        reader = YamlReader.from_file(path)
        reader.get_choice("type", ["image"], "image")
        resolution = reader.get_float("resolution", above=0.0)
        origin = reader.get_pose("origin")
        occupied_thresh = read_threshold(reader)
        free_thresh = reader.get_float("free_thresh", _FREE)
        negate = reader.get_choice("negate", ["0", "1", "false", "true"], "0") in ("1", "true")
        mode = reader.get_choice("mode", ["trinary", "scale"], "trinary")
        image = reader.get_path("image")
        reader.finish()
        return cls(
            path,
            image,
            resolution,
            origin,
            occupied_thresh,
            free_thresh,
            negate,
            is_scaled=mode == "scale",
        )

    @property
    def cells(self) -> Int8Array:
        """The cells of map_server's OccupancyGrid: shape (height, width), the lowest row first.

        0 is free, 100 occupied, -1 unknown.

        Raises:
            YamlError: the image cannot be read.
        """
        cells: Int8Array = read_image(self.image, self._cells)
        return cells[::-1]

    def is_bright(self, image: "Image.Image") -> BoolArray:
        """The mask of free and unknown pixels: shape (height, width), the top row first."""
        return np.asarray(self._cells(image) != _OCCUPIED)

    def _cells(self, image: "Image.Image") -> Int8Array:
        if image.mode.startswith(("I", "F")):
            raise YamlError(self.image, "expected 8 bits per channel, as map_server does")
        has_alpha = "A" in image.mode or "transparency" in image.info
        channels = np.asarray(image.convert("RGBA" if has_alpha else "RGB"))
        # In trinary maps, map_server averages alpha with the colours.
        used = channels[:, :, :3] if self.is_scaled else channels
        number = used.shape[2]
        grey = np.arange(255 * number + 1) / number
        of_grey = self._cells_of((grey if self.negate else 255.0 - grey) / 255.0)
        cells: Int8Array = of_grey[used.sum(axis=2, dtype=np.uint16)]
        if has_alpha and self.is_scaled:
            cells[channels[:, :, 3] < 255] = _UNKNOWN
        return cells

    def _cells_of(self, occupancy: FloatArray) -> Int8Array:
        free, occupied = self.free_thresh, self.occupied_thresh
        between: Any = _UNKNOWN
        if self.is_scaled:
            between = np.rint((occupancy - free) / max(occupied - free, 1e-9) * 100.0)
        cells = np.where(occupancy < free, _FREE_CELL, between)
        return np.where(occupancy > occupied, _OCCUPIED, cells).astype(np.int8)


@dataclass(frozen=True)
class LineMap:
    """A map and its lines.

    Attributes:
        source: the map.
        outlines: of the occupied pixels [px]: shape (n, 4), x1, y1, x2, y2.
        lines: the same with fewer corners [px]: shape (m, 4).
        deviation: the largest distance between outlines and lines [m].
    """

    source: ServerMap
    outlines: Segments
    lines: Segments
    deviation: float

    @classmethod
    def from_file(cls, path: Path, tolerance: Optional[float] = None) -> "LineMap":
        """Reads a map.

        Args:
            path: path of the map's YAML file.
            tolerance: the largest deviation [m]; by default that of one pixel.

        Raises:
            YamlError: something in the file, or in the image, is wrong.
        """
        source = ServerMap.from_file(path)
        outlines = wall_outlines.outlines(read_image(source.image, source.is_bright))
        pixels = 1.0 if tolerance is None else tolerance / source.resolution
        simplified = simplify(outlines, pixels)
        return cls(source, outlines, simplified.segments, simplified.deviation * source.resolution)

    def in_world(self, segments: Segments) -> Segments:
        """Outlines or lines in the world [m]: shape (n, 4)."""
        return place(segments * self.source.resolution, self.source.origin)

    def write(self, path: Path) -> Path:
        """Writes the lines as a map of type line_segments.

        The numbers are corners of pixels, so that nothing is rounded.

        Args:
            path: of the YAML file; the segments are written into a file beside it.

        Returns:
            The file of the segments.

        Raises:
            FlatlandError: a file cannot be written.
        """
        data = path.with_suffix(".dat")
        x, y, yaw = self.source.origin
        yaml = (
            f"# From {self.source.path.name}, by flatland map_to_lines.\n"
            "type: line_segments\n"
            f"data: {data.name}\n"
            f"scale: {self.source.resolution!r}\n"
            f"origin: [{x!r}, {y!r}, {yaw!r}]\n"
        )
        rows = [" ".join(f"{value:g}" for value in row) for row in self.lines.tolist()]
        try:
            data.write_text("".join(f"{row}\n" for row in rows), encoding="utf-8")
            path.write_text(yaml, encoding="utf-8")
        except OSError as error:
            raise FlatlandError(f"{error.filename}: cannot be written: {error.strerror}") from None
        return data

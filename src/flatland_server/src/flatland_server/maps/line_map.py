"""Makes a layer of line segments from a map of map_server.

An image layer compares grey values with a threshold alone; here map_server's parameters apply:
`negate`, `occupied_thresh` and `mode` (http://wiki.ros.org/map_server, section 1.2).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Optional

import numpy as np

from flatland_server.arrays import BoolArray, Segments
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import FlatlandError, YamlError
from flatland_server.geometry import Pose
from flatland_server.maps import wall_outlines
from flatland_server.maps.map_reader import place, read_image, read_threshold
from flatland_server.maps.simplify_outlines import simplify

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
        negate: whether white is occupied, instead of black.
    """

    path: Path
    image: Path
    resolution: float
    origin: Pose
    occupied_thresh: float
    negate: bool

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
        reader.get_float("free_thresh", 0.0)  # between free and occupied is unknown, not a wall
        negate = reader.get_choice("negate", ["0", "1", "false", "true"], "0") in ("1", "true")
        reader.get_choice("mode", ["trinary", "scale"], "trinary")  # they differ in what is free
        image = reader.get_path("image")
        reader.finish()
        return cls(path, image, resolution, origin, occupied_thresh, negate)

    def is_bright(self, image: "Image.Image") -> BoolArray:
        """The mask of free and unknown pixels: shape (height, width), the top row first."""
        if image.mode.startswith(("I", "F")):
            raise YamlError(self.image, "expected 8 bits per channel, as map_server does")
        grey = np.asarray(image.convert("RGB"), dtype=np.float32).mean(axis=2)
        occupancy = (grey if self.negate else 255.0 - grey) / 255.0
        return np.asarray(occupancy <= np.float32(self.occupied_thresh))


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
            path: its YAML file.
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

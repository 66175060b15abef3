"""The free pixels of a map image."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from PIL import Image

from flatland_server.arrays import BoolArray, FloatArray
from flatland_server.maps.wall_outlines import bright_pixels


class FreeSpace(NamedTuple):
    """The free pixels of a map."""

    free: BoolArray
    """True where a pixel is free, the bottom row first."""

    resolution: float
    """Side of a pixel [m]."""

    origin: FloatArray
    """The bottom left corner [m]."""


def read_free_space(map_file: Path) -> FreeSpace:
    """Reads a map with an origin that is not rotated."""
    layer = yaml.safe_load(map_file.read_text())
    with Image.open(map_file.parent / layer["image"]) as image:
        free = bright_pixels(image, layer["occupied_thresh"])[::-1]
    return FreeSpace(free, layer["resolution"], np.array(layer["origin"][:2], np.float64))

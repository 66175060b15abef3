"""The free pixels of a map image, and which of them are connected."""

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
    """By pixel, the bottom row first."""

    resolution: float
    """Side of a pixel [m]."""

    origin: FloatArray
    """The bottom left corner [m]."""


def read_free_space(map_file: Path) -> FreeSpace:
    """Reads a map whose origin is not rotated."""
    layer = yaml.safe_load(map_file.read_text())
    with Image.open(map_file.parent / layer["image"]) as image:
        free = bright_pixels(image, layer["occupied_thresh"])[::-1]
    return FreeSpace(free, layer["resolution"], np.array(layer["origin"][:2], np.float64))


def reachable(free: BoolArray, row: int, column: int) -> BoolArray:
    """The free pixels connected with a given one (4-connectivity)."""
    reached = np.zeros_like(free)
    reached[row, column] = free[row, column]
    before = 0
    while np.count_nonzero(reached) > before:
        before = np.count_nonzero(reached)
        reached = _spread(reached, free)
        reached = _spread(reached.T, free.T).T
    return reached


def _spread(reached: BoolArray, free: BoolArray) -> BoolArray:
    """Extends the reached pixels along the rows."""
    breaks = ~free
    breaks[:, 0] = True
    run = np.cumsum(breaks.ravel())  # the free pixels of a run share a number
    is_reached = np.bincount(run, weights=reached.ravel()) > 0
    return np.asarray(is_reached[run].reshape(free.shape) & free)

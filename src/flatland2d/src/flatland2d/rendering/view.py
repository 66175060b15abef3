"""The section of the world that a picture shows, and its scale."""

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np

from flatland_server.arrays import FloatArray
from flatland_server.canvas import Points
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Point

Size = Tuple[int, int]
"""Width and height [px]."""

LARGEST = 16384
"""The longest side of a picture [px]."""

_MARGIN = 0.025  # of the longer side
_LEAST_EXTENT = 2.0  # m
_SCALES = (0.01, 1e4)  # px/m


@dataclass(frozen=True)
class View:
    """A section of the world as pixels: x to the right, y upwards.

    Pixels are counted on a grid that is fixed to the world's origin, so that a picture of a moving
    section can be put together from parts that do not change.

    Attributes:
        left: column of the picture's first pixels; that of the world's origin is 0 [px].
        top: row of the picture's first pixels, counted downwards from the world's origin [px].
        scale: [px/m].
        size: the picture's size [px].
    """

    left: int
    top: int
    scale: float
    size: Size

    @classmethod
    def around(cls, center: Point, scale: float, size: Size) -> "View":
        """A view with a point [m] in its middle.

        Raises:
            FlatlandError: the size is below one pixel, or above 16384.
        """
        check_size(size)
        scale = min(max(scale, _SCALES[0]), _SCALES[1])
        left = round(center[0] * scale - size[0] / 2)
        top = round(-center[1] * scale - size[1] / 2)
        return cls(left, top, scale, size)

    @classmethod
    def of(cls, low: Point, high: Point, size: Size) -> "View":
        """A view of the area between two corners [m], with a margin."""
        check_size(size)
        low, high = _extended(low, high)
        margin = _MARGIN * max(size)
        room = [max(1.0, side - 2 * margin) for side in size]
        scale = min(room[i] / (high[i] - low[i]) for i in (0, 1))
        center = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)
        return cls.around(center, scale, size)

    def pixels(self, points: Points) -> FloatArray:
        """Positions [m] as columns and rows [px]: shape (n, 2)."""
        place = np.asarray(points, dtype=float).reshape(-1, 2)
        return place * (self.scale, -self.scale) - (self.left, self.top)

    def position(self, pixel: Point) -> Point:
        """The position [m] of a column and row [px]."""
        return (pixel[0] + self.left) / self.scale, -(pixel[1] + self.top) / self.scale

    @property
    def center(self) -> Point:
        """The position in the middle of the picture [m]."""
        return self.position((self.size[0] / 2, self.size[1] / 2))

    @property
    def extent(self) -> Tuple[float, float, float, float]:
        """Left, right, bottom and top [m]."""
        left, top = self.position((0, 0))
        right, bottom = self.position(self.size)
        return left, right, bottom, top


def fitting_size(low: Point, high: Point, longest: int) -> Size:
    """The size of a picture of the area between two corners [m], with a margin.

    Args:
        low: lower left corner.
        high: upper right corner.
        longest: the longer side of the picture [px].
    """
    low, high = _extended(low, high)
    margin = _MARGIN * longest
    scale = (longest - 2 * margin) / max(high[0] - low[0], high[1] - low[1])
    width, height = (round((high[i] - low[i]) * scale + 2 * margin) for i in (0, 1))
    return max(1, width), max(1, height)


def check_size(size: Size) -> None:
    """Checks the size of a picture.

    Raises:
        FlatlandError: it is not a width and a height from 1 to 16384 pixels.
    """
    is_pair = isinstance(size, (tuple, list)) and len(size) == 2
    if not is_pair or not all(
        isinstance(side, (int, np.integer)) and 1 <= side <= LARGEST for side in size
    ):
        raise FlatlandError(
            f"expected a width and a height of 1 to {LARGEST} pixels, found {size!r}"
        )


def _extended(low: Point, high: Point) -> Tuple[Point, Point]:
    """An area that is not too small, with the same centre."""
    grow = [max(0.0, _LEAST_EXTENT - (high[i] - low[i])) / 2 for i in (0, 1)]
    # Beyond some size a picture shows nothing; and coordinates stay finite.
    if not all(math.isfinite(value) for value in (*low, *high)):
        return (-1.0, -1.0), (1.0, 1.0)
    return (low[0] - grow[0], low[1] - grow[1]), (high[0] + grow[0], high[1] + grow[1])

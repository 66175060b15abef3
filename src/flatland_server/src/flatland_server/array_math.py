"""Trigonometry and distances of many points.

NumPy computes sines and the like with SIMD instructions, unless it believes that the memory of the
result overlaps the argument. For a strided argument, such as a column of a larger array, its check
is too cautious: a result that lies right behind the argument is computed without SIMD, and differs
in its last bits. `cos_sin` and `headings` make arguments contiguous first, so that equal numbers
give equal bits wherever they lie in memory.
"""

from typing import Tuple

import numpy as np

from flatland_server.arrays import FloatArray
from flatland_server.geometry import Point


def cos_sin(angles: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """The cosines and sines of angles, in arrays of the same shape.

    Args:
        angles: [rad].
    """
    angles = np.ascontiguousarray(angles)
    return np.cos(angles), np.sin(angles)


def headings(vectors: FloatArray) -> FloatArray:
    """The angles of vectors, in [-pi, pi] [rad]; 0 for the vector (0, 0).

    Args:
        vectors: shape (..., 2).
    """
    x, y = np.ascontiguousarray(np.moveaxis(vectors, -1, 0))
    return np.asarray(np.arctan2(y, x))


def is_enclosed(point: Point, segments: FloatArray) -> bool:
    """True if a point is inside of closed outlines, by the even-odd rule.

    From within, one crosses an odd number of them.

    Args:
        point: x, y [m].
        segments: x1, y1, x2, y2 [m]: shape (m, 4).
    """
    (x, y), (x1, y1, x2, y2) = point, segments.T
    rows = np.flatnonzero((y1 > y) != (y2 > y))
    x1, y1, x2, y2 = (each[rows] for each in (x1, y1, x2, y2))
    crossings = x1 + (y - y1) / (y2 - y1) * (x2 - x1) > x  # to the right
    return bool(np.count_nonzero(crossings) % 2)


def from_segments(points: FloatArray, segments: FloatArray) -> FloatArray:
    """The vectors from the nearest points of segments to points [m]: shape (n, m, 2).

    Args:
        points: shape (n, 2).
        segments: x1, y1, x2, y2, shape (m, 4), or (n, m, 4) with m segments for each point. Their
            length may be 0.
    """
    starts = segments[..., :2]
    steps = segments[..., 2:] - starts
    to_point = points[:, np.newaxis] - starts
    squares = np.einsum("...i,...i->...", steps, steps)
    along = np.einsum("...i,...i->...", to_point, steps) / np.where(squares > 0.0, squares, 1.0)
    along = np.minimum(np.maximum(along, 0.0), 1.0)  # quicker than clip
    return np.asarray(to_point - along[..., np.newaxis] * steps)

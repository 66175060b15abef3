"""Trigonometry that gives the same bits for the same numbers, wherever they lie in memory.

NumPy computes sines and the like with SIMD instructions, or without them if it takes the result's
memory for a part of the argument's. For an argument with gaps, such as a column of a larger array,
it looks too far: a result that happens to lie right behind it is computed without, and differs in
its last bits. These functions close the gaps first.
"""

from typing import Tuple

import numpy as np

from flatland_server.arrays import FloatArray


def cos_sin(angles: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """The cosines and sines of angles, of the shape of these.

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

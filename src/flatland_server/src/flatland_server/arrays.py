"""Type names for NumPy arrays, with their element types for the type checker.

The NumPy version of ROS Noetic has no `numpy.typing`; at run time they are all `numpy.ndarray`.
"""

from typing import TYPE_CHECKING, Any, Sequence, Union

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike as ArrayLike
    from numpy.typing import NDArray

    _Array = Union[NDArray[np.floating[Any]], NDArray[np.integer[Any]]]
    BoolArray = NDArray[np.bool_]
    IntArray = NDArray[np.intp]
    Int32Array = NDArray[np.int32]
    FloatArray = NDArray[np.float64]
    Float32Array = NDArray[np.float32]
    UInt8Array = NDArray[np.uint8]
else:
    BoolArray = IntArray = Int32Array = FloatArray = Float32Array = UInt8Array = np.ndarray
    _Array = np.ndarray
    ArrayLike = Any

Segments = FloatArray
"""Wall segments: shape (n, 4), x1, y1, x2, y2; in metres unless stated otherwise."""

Numbers = Union[Sequence[float], _Array]
"""A tuple, a list or an array of numbers."""

PoseLike = Numbers
"""x, y [m] and yaw [rad]: a `Pose`, a tuple, a list or an array of three numbers."""

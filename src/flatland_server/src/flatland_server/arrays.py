"""Type names for NumPy arrays, with their element types for the type checker.

The NumPy version of ROS Noetic has no `numpy.typing`; at run time they are all `numpy.ndarray`.
"""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    BoolArray = NDArray[np.bool_]
    IntArray = NDArray[np.intp]
    Int32Array = NDArray[np.int32]
    FloatArray = NDArray[np.float64]
    Float32Array = NDArray[np.float32]
    UInt8Array = NDArray[np.uint8]
else:
    BoolArray = IntArray = Int32Array = FloatArray = Float32Array = UInt8Array = np.ndarray

Segments = FloatArray
"""Wall segments: shape (n, 4), x1, y1, x2, y2; in metres unless stated otherwise."""

"""Type names for NumPy arrays, with their element types for the type checker, and arrays of files.

The NumPy version of ROS Noetic has no `numpy.typing`; at run time they are all `numpy.ndarray`.
"""

import io
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
    Int8Array = NDArray[np.int8]
    UInt8Array = NDArray[np.uint8]
else:
    BoolArray = IntArray = Int32Array = FloatArray = Float32Array = np.ndarray
    Int8Array = UInt8Array = np.ndarray
    _Array = np.ndarray
    ArrayLike = Any

Segments = FloatArray
"""Wall segments: shape (n, 4), x1, y1, x2, y2; in metres unless stated otherwise."""

Numbers = Union[Sequence[float], _Array]
"""A tuple, a list or an array of numbers."""

PoseLike = Numbers
"""x, y [m] and yaw [rad]: a `Pose`, a tuple, a list or an array of three numbers."""


def npy_array(data: bytes) -> Any:
    """The array of a file .npy: of the bytes that are there, whatever size the header tells.

    Args:
        data: content of the file.

    Raises:
        ValueError: it is none, or has not as many bytes as the header tells.
    """
    npy: Any = np.lib.format  # without types
    stream = io.BytesIO(data)
    try:
        is_first = npy.read_magic(stream) == (1, 0)
        read = npy.read_array_header_1_0 if is_first else npy.read_array_header_2_0
        shape, is_fortran, dtype = read(stream)
        values = np.frombuffer(data, dtype, offset=stream.tell())
    except (EOFError, KeyError, TypeError, RuntimeError) as error:
        raise ValueError(f"not an array of NumPy: {error}") from None
    return values.reshape(shape, order="F" if is_fortran else "C")

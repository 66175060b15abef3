"""The part of the window in C++: the library with rviz's tools and displays."""

import ctypes
from functools import lru_cache


@lru_cache(maxsize=None)
def library() -> ctypes.CDLL:
    """The library. It has functions for what rviz's Python bindings lack."""
    return ctypes.CDLL("libflatland_viz_tools.so")

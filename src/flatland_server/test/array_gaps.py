"""Tells whether NumPy computes functions of arrays with gaps in memory; see array_math.py."""

from typing import Callable, List

import numpy as np
import pytest

_FUNCTIONS = ("arccos", "arcsin", "arctan2", "cos", "exp", "log", "power", "sin", "tan", "tanh")


def watch_gaps(monkeypatch: pytest.MonkeyPatch) -> List[str]:
    """Returns a list that receives the name of each function called with such an array."""
    found: List[str] = []
    for name in _FUNCTIONS:
        monkeypatch.setattr(np, name, _watched(getattr(np, name), found))
    return found


def _watched(function: Callable[..., object], found: List[str]) -> Callable[..., object]:
    def watched(*arguments: object) -> object:
        if any(_has_gaps(each) for each in arguments if isinstance(each, np.ndarray)):
            found.append(function.__name__)
        return function(*arguments)

    return watched


def _has_gaps(array: np.ndarray) -> bool:
    """True if the elements, in any order, are not contiguous in memory."""
    extents = [(count - 1) * abs(stride) for count, stride in zip(array.shape, array.strides)]
    return array.size > 0 and sum(extents) + array.itemsize > array.nbytes

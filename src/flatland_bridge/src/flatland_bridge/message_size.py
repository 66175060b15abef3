"""The memory that messages take, by their types: what is the same in each is added up once."""

import sys
from functools import lru_cache
from operator import attrgetter
from typing import Any, Callable, List, NamedTuple, Tuple

import numpy as np

from flatland_bridge.plain_form import parse_type
from flatland_server.messages import NUMBERS, get

_OBJECT, _NUMBER, _POINTER = 56, 32, 8
"""Bytes of an object of Python without its fields, of a number, and of a reference."""

Measure = Callable[[Any], int]


class _Sizes(NamedTuple):
    """The sizes of a message type.

    Attributes:
        fixed: bytes of each message.
        others: measure the further bytes of the fields that have some, by the paths of the fields.
    """

    fixed: int
    others: List[Tuple[str, Measure]]


def size_of(message: Any) -> int:
    """The memory of a message with all that it contains, roughly [bytes].

    Args:
        message: of a class of ROS or of ours. Fields with values of another type are left out.
    """
    message_type: Any = type(message)
    size, others = _getters(message_type)
    try:
        for value, measure in others:
            size += measure(value(message))
    except TypeError:  # it cannot be sent either
        pass
    return size


@lru_cache(maxsize=None)
def _getters(message_type: Any) -> Tuple[int, List[Tuple[Callable[[Any], Any], Measure]]]:
    fixed, others = _sizes(message_type)
    return fixed, [(attrgetter(path), measure) for path, measure in others]


@lru_cache(maxsize=None)
def _sizes(message_type: Any) -> _Sizes:
    fixed, others = _OBJECT, []
    for name, text in zip(message_type.__slots__, message_type._slot_types):
        kind = parse_type(text)
        fixed += _POINTER
        if kind.is_array and kind.length is not None and kind.base in NUMBERS:
            fixed += _OBJECT + kind.length * (_POINTER + _NUMBER)
        elif kind.is_array:
            others.append((name, _array_measure(kind.base)))
        elif kind.base == "string":
            others.append((name, sys.getsizeof))
        elif "/" in kind.base:
            nested = _sizes(get(kind.base))
            fixed += nested.fixed
            others += [(f"{name}.{path}", measure) for path, measure in nested.others]
        else:  # a time has two numbers
            fixed += _OBJECT + 2 * _NUMBER if kind.base in ("time", "duration") else _NUMBER
    return _Sizes(fixed, others)


def _array_measure(base: str) -> Measure:
    if base == "string":
        item: Measure = sys.getsizeof
    elif "/" in base:
        nested = _sizes(get(base))
        if not nested.others:
            return lambda values: sys.getsizeof(values) + nested.fixed * len(values)
        item = size_of
    else:
        return _numbers_size
    return lambda values: sys.getsizeof(values) + sum(map(item, values))


def _numbers_size(values: Any) -> int:
    if isinstance(values, np.ndarray):
        return _OBJECT + int(values.nbytes)
    if isinstance(values, (bytes, bytearray)):
        return sys.getsizeof(values)
    return sys.getsizeof(values) + _NUMBER * len(values)

"""A message of a topic, on its way to the clients of all protocols, and the memory it takes."""

import sys
from collections import deque
from functools import lru_cache
from operator import attrgetter
from typing import Any, Callable, Deque, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from flatland_bridge.budget import ENTRY
from flatland_bridge.plain_form import parse_type
from flatland_server.messages import NUMBERS, deserialized, get, serialized

_MOST_KEPT, _LARGEST_KEPT = 64, 64_000
_kept: Deque[Tuple[Dict[str, bytes], str]] = deque()
"""The latest encodings of messages, for further clients that want the same: 64 of at most 64 kB."""

_OBJECT, _NUMBER, _POINTER = 56, 32, 8
"""Bytes of an object of Python without its fields, of a number, and of a reference."""

Measure = Callable[[Any], int]


class Sample:
    """A message of a topic, converted once for all clients.

    Args:
        topic: absolute name of the topic, such as "/robot1/scan".
        nanoseconds: simulated time [ns].
        message_type: the class of the message.
        message: the message, which may be serialized in advance; or None.
        data: the serialized message; for a sample without a message object.
        is_latched: whether new subscribers get the message, so that it is kept in any case.
    """

    def __init__(
        self,
        topic: str,
        nanoseconds: int,
        message_type: Any,
        message: Optional[Any] = None,
        data: Optional[bytes] = None,
        is_latched: bool = False,
    ) -> None:
        self.topic = topic
        self.nanoseconds = nanoseconds
        self.message_type = message_type
        self.is_latched = is_latched
        self._message = message
        self._data = data
        self._size: Optional[int] = None
        self._encodings: Dict[str, bytes] = {}

    @property
    def message(self) -> Any:
        """The message with all of its fields."""
        # One that is serialized in advance, or when it is sent, has no fields.
        if type(self._message) is self.message_type:
            return self._message
        return deserialized(self.message_type, self.data)

    @property
    def data(self) -> bytes:
        """The serialized message."""
        if self._data is not None:
            return self._data
        return self.encoded("ros1", lambda sample: serialized(sample._message))

    def encoded(self, name: str, encode: Callable[["Sample"], bytes]) -> bytes:
        """The bytes that a protocol sends.

        Args:
            name: the encoding's name.
            encode: called with the sample at the first use of the encoding.
        """
        data = self._encodings.get(name)
        if data is None:
            data = encode(self)
            if len(data) <= _LARGEST_KEPT:
                self._encodings[name] = data
                _kept.append((self._encodings, name))
                if len(_kept) > _MOST_KEPT:
                    encodings, oldest = _kept.popleft()
                    encodings.pop(oldest, None)
        return data

    @property
    def size(self) -> int:
        """The memory that it takes while it waits, roughly [bytes]."""
        if self._size is None:
            if self._data is not None:
                size = len(self._data)
            elif type(self._message) is self.message_type:
                size = size_of(self._message)
            else:
                size = len(getattr(self._message, "_data", b""))
            self._size = ENTRY + size
        return self._size


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

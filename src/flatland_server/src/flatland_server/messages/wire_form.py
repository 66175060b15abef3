"""The serialized form of messages: little-endian, field after field, as ROS sends and records it.

A field that is an array or a string has its length before it (uint32), unless an array's length is
fixed. A time is two uint32, a duration two int32. See https://wiki.ros.org/ROS/Technical%20Overview.
"""

import struct
from abc import ABC, abstractmethod
from functools import cached_property
from io import BytesIO
from typing import Any, List, Optional, Sequence, Tuple

from flatland_server.exceptions import MessageError, shortened

WRONG_VALUE = (struct.error, ArithmeticError, AttributeError, TypeError, ValueError)
"""The exceptions that wrong field values raise during serialization."""

LENGTH = struct.Struct("<I")
"""The length of a string or array, which precedes its content."""

MOST_OBJECTS = 100_000
"""Messages within a message: some 20 MB."""


class ObjectBudget:
    """The objects that may still be made of received data, of which a few bytes may mean many.

    Args:
        most: greatest number of objects.
    """

    def __init__(self, most: int = MOST_OBJECTS) -> None:
        self._left = self._most = most

    def take(self, count: int) -> None:
        """Counts objects, before they are made.

        Raises:
            MessageError: there are too many.
        """
        self._left -= count
        if self._left < 0:
            raise MessageError(f"expected {self._most} messages within a message or fewer")


def objects_in(value: Any) -> int:
    """The messages and times that a default value is made of, and eighths of numbers in arrays."""
    if isinstance(value, (list, bytes)):
        return len(value) // 8 + sum(map(objects_in, value))
    if not hasattr(value, "__slots__"):
        return 0
    return 1 + sum(objects_in(getattr(value, name)) for name in value.__slots__)


class Reader:
    """Takes values from serialized data.

    Args:
        data: the serialized values.
        errors: "strict" refuses strings that are not UTF-8, "surrogateescape" keeps their bytes.

    Attributes:
        budget: of the objects that are made of the data: one for 4 bytes, as many as fit into
            messages of numbers, or `MOST_OBJECTS`.
    """

    def __init__(self, data: bytes, errors: str = "surrogateescape") -> None:
        self._data = data
        self._size = len(data)
        self._errors = errors
        self._offset = 0
        self.budget = ObjectBudget(max(MOST_OBJECTS, self._size // 4))

    def bytes(self, length: int) -> bytes:
        """The next bytes.

        Raises:
            MessageError: there are fewer.
        """
        begin, end = self._offset, self._offset + length
        if end > self._size:
            raise self._error(end)
        self._offset = end
        return self._data[begin:end]

    def numbers(self, form: struct.Struct) -> Tuple[Any, ...]:
        """The next numbers of a form.

        Raises:
            MessageError: there are fewer bytes.
        """
        begin, end = self._offset, self._offset + form.size
        if end > self._size:
            raise self._error(end)
        self._offset = end
        return form.unpack_from(self._data, begin)

    def length(self, item_size: int, fixed: Optional[int] = None) -> int:
        """The length of a string or an array; a fixed one is not in the data.

        Args:
            item_size: least number of bytes of an item.
            fixed: length, if the type has one.

        Raises:
            MessageError: there are fewer bytes than so many items have.
        """
        length: int = self.numbers(LENGTH)[0] if fixed is None else fixed
        if self._offset + length * item_size > self._size:
            raise self._error(self._offset + length * item_size)
        return length

    def string(self) -> str:
        """The next string.

        Raises:
            MessageError: there are fewer bytes than its length, or they are not UTF-8.
        """
        data = self.bytes(self.length(1))
        try:
            return data.decode("utf-8", self._errors)
        except UnicodeDecodeError:
            raise MessageError(f"expected UTF-8, found {shortened(repr(data))}") from None

    def _error(self, end: int) -> MessageError:
        return MessageError(
            f"expected {end} bytes or more of a serialized message, found {self._size}"
        )


class Part(ABC):
    """Consecutive fields of a message, or one."""

    @property
    @abstractmethod
    def least_size(self) -> int:
        """Bytes of the serialized fields if strings are empty, and arrays of any length."""

    @abstractmethod
    def write(self, message: Any, chunks: List[bytes]) -> None:
        """Appends the serialized fields of a message."""

    @abstractmethod
    def read(self, message: Any, reader: Reader) -> None:
        """Sets the fields of a message."""

    @abstractmethod
    def problem(self, message: Any) -> Optional[str]:
        """The first field that cannot be written, with the expected and the found value."""


class WireForm:
    """The serialized form of a message type."""

    def __init__(self, parts: Sequence[Part]) -> None:
        self._parts = parts

    @cached_property
    def least_size(self) -> int:
        """Bytes of the shortest message."""
        return sum(part.least_size for part in self._parts)

    def write(self, message: Any, chunks: List[bytes]) -> None:
        """Appends a message, in one or more pieces."""
        for part in self._parts:
            part.write(message, chunks)

    def read(self, message: Any, reader: Reader) -> None:
        """Sets all fields of a message, in which nested messages exist already."""
        for part in self._parts:
            part.read(message, reader)

    def problem(self, message: Any) -> str:
        """The problem of a message that could not be written."""
        return next(filter(None, (part.problem(message) for part in self._parts)), ": wrong value")


def serialized(message: Any) -> bytes:
    """A message of a class of ROS or of ours, as bytes."""
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def with_owner(owner: str, problem: str) -> str:
    """A problem of a field, with the path of the message that contains it."""
    return f"{owner}{problem}" if problem.startswith(":") else f"{owner}.{problem}"

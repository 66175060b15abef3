"""The serialized form of messages: little-endian, field after field, as ROS sends and records it.

A field that is an array or a string has its length before it (uint32), unless an array's length is
fixed. A time is two uint32, a duration two int32. See https://wiki.ros.org/ROS/Technical%20Overview.
"""

import struct
from abc import ABC, abstractmethod
from io import BytesIO
from typing import Any, List, Optional, Sequence, Tuple

from flatland_server.exceptions import MessageError

WRONG_VALUE = (struct.error, ArithmeticError, AttributeError, TypeError, ValueError)
"""The exceptions that wrong field values raise during serialization."""

LENGTH = struct.Struct("<I")
"""The length of a string or array, which precedes its content."""


class Reader:
    """Takes values from serialized data."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._offset = 0

    def bytes(self, length: int) -> bytes:
        """The next bytes.

        Raises:
            MessageError: there are fewer.
        """
        begin, end = self._offset, self._offset + length
        if end > len(self._data):
            raise MessageError(
                f"expected {end} bytes or more of a serialized message, found {len(self._data)}"
            )
        self._offset = end
        return self._data[begin:end]

    def numbers(self, form: struct.Struct) -> Tuple[Any, ...]:
        """The next numbers of a form."""
        return form.unpack(self.bytes(form.size))

    def length(self, fixed: Optional[int] = None) -> int:
        """The length of a string or an array; a fixed one is not in the data."""
        return int(self.numbers(LENGTH)[0]) if fixed is None else fixed


class Part(ABC):
    """Consecutive fields of a message, or one."""

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

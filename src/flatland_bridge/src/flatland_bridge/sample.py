"""A message of a topic, on its way to the clients of all protocols."""

from collections import deque
from typing import Any, Callable, Deque, Dict, Optional, Tuple

from flatland_bridge.budget import ENTRY
from flatland_bridge.message_size import size_of
from flatland_server.messages import deserialized, serialized

_MOST_KEPT, _LARGEST_KEPT = 64, 64_000
_kept: Deque[Tuple[Dict[str, bytes], str]] = deque()
"""The latest encodings of messages, for further clients that want the same: 64 of at most 64 kB."""


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

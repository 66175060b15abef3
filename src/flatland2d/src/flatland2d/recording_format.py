"""A format of recordings: a beginning, chunks of messages, an index. It makes bytes, no files."""

import struct
from abc import ABC, abstractmethod
from mmap import mmap
from typing import ClassVar, Dict, Iterator, List, NamedTuple, Tuple, Union

from flatland_server.exceptions import RecordingError

LARGEST_CHUNK = 128 * 1024 * 1024  # bytes
"""Without compression. Those of Flatland have a megabyte, or one message that is larger."""

_COUNT = struct.Struct("<I")

Bytes = Union[bytes, mmap]

Messages = Dict[int, List[Tuple[int, int]]]
"""The times [ns] of messages and their offsets in a chunk, by the numbers of their channels."""


class Channel(NamedTuple):
    """A topic with the type of its messages."""

    topic: str
    """Its absolute name."""
    type: str
    """The name of the type, as package/Name, or package/msg/Name of ROS 2."""
    checksum: str
    """Of the type: its MD5 sum, or the RIHS01 hash of ROS 2."""
    definition: str
    """The text of the type and of all types in it."""
    is_latched: bool
    """Whether a player repeats the last message to subscribers that come later."""
    encoding: str = "ros1"
    """Of the messages: ros1, or cdr, as ROS 2 has them."""


class Recorded(NamedTuple):
    """A serialized message with its simulated time."""

    channel: Channel
    nanoseconds: int
    data: bytes


class Chunk(NamedTuple):
    """A chunk of the file."""

    position: int
    """The offset of its first byte in the file."""
    start: int
    """The smallest time of its messages [ns]."""
    end: int
    """The largest time of its messages [ns]."""
    counts: Dict[int, int]
    """The number of messages of each channel."""
    entry: bytes
    """Its record in the index."""


class Format(ABC):
    """Builds the bytes of one recording.

    Attributes:
        magic: the first bytes of each file.
        encodings: those of messages that it may have.
        chunks: those that were closed.

    Args:
        encoding: encoding of the messages, one of `encodings`.
    """

    magic: ClassVar[bytes]
    encodings: ClassVar[Tuple[str, ...]] = ("ros1",)

    def __init__(self, encoding: str) -> None:
        self._encoding = encoding
        self.chunks: List[Chunk] = []
        self._channels: Dict[Channel, int] = {}
        self._data = bytearray()  # of the open chunk
        self._messages: Messages = {}

    @property
    def size(self) -> int:
        """The size of the open chunk [bytes]."""
        return len(self._data)

    def add(self, message: Recorded) -> None:
        """Adds a message to the open chunk."""
        channel, nanoseconds, data = message
        number = self._channels.get(channel)
        if number is None:
            number = self._channels[channel] = len(self._channels) + 1
            self._data += self._channel_record(number, channel)
        self._messages.setdefault(number, []).append((nanoseconds, len(self._data)))
        self._data += self._message_record(number, nanoseconds, data)

    def take_chunk(self, position: int) -> bytes:
        """Closes the open chunk, which has messages.

        Args:
            position: the offset in the file at which it will be.
        """
        times = [time for messages in self._messages.values() for time, _ in messages]
        counts = {number: len(messages) for number, messages in self._messages.items()}
        start, end = min(times), max(times)
        content, entry = self._chunk_record(position, start, end, bytes(self._data), self._messages)
        self.chunks.append(Chunk(position, start, end, counts, entry))
        self._data, self._messages = bytearray(), {}
        return content

    def drop_chunk(self) -> int:
        """Takes the last chunk out of the index; returns its offset in the file."""
        return self.chunks.pop().position

    @abstractmethod
    def beginning(self, index_position: int) -> bytes:
        """The bytes before the first chunk, always of the same size.

        Args:
            index_position: the offset of the index in the file, 0 if there is none yet.
        """

    @abstractmethod
    def index(self, position: int) -> bytes:
        """The index, which ends the file."""

    @classmethod
    @abstractmethod
    def read(cls, data: Bytes) -> Iterator[Recorded]:
        """The messages of a file that Flatland has written.

        Raises:
            Damaged: after the last complete chunk, if the file was not finished.
            RecordingError: it is compressed in a way that cannot be read.
        """

    @abstractmethod
    def _channel_record(self, number: int, channel: Channel) -> bytes: ...

    @abstractmethod
    def _message_record(self, number: int, nanoseconds: int, data: bytes) -> bytes: ...

    @abstractmethod
    def _chunk_record(
        self, position: int, start: int, end: int, data: bytes, messages: Messages
    ) -> Tuple[bytes, bytes]:
        """A chunk with the index of its messages, and its entry in the index of the file."""


class Damaged(Exception):
    """A recording ends here, or goes on with something else."""


class Fields:
    """Takes values out of bytes, one after the other.

    Raises:
        Damaged: by each method, if there are too few bytes.
    """

    def __init__(self, data: Bytes) -> None:
        self._data = data
        self._at = 0

    def __bool__(self) -> bool:
        """True if there are bytes left."""
        return self._at < len(self._data)

    def take(self, count: int) -> bytes:
        """The next bytes."""
        self._at += count
        if self._at > len(self._data):
            raise Damaged
        return self._data[self._at - count : self._at]

    def number(self, size: int) -> int:
        """The next number, little-endian, of this many bytes."""
        return int.from_bytes(self.take(size), "little")

    def block(self, size: int = 4) -> bytes:
        """The next bytes, after a number of this many bytes that counts them."""
        return self.take(self.number(size))

    def rest(self) -> bytes:
        """All bytes that are left."""
        return self.take(len(self._data) - self._at)

    def text(self) -> str:
        """The next block as text."""
        return self.block().decode(errors="replace")


def block(data: bytes) -> bytes:
    """Bytes after their count."""
    return _COUNT.pack(len(data)) + data


def unreadable_compression(name: str) -> RecordingError:
    """The error of a chunk that another program has compressed."""
    return RecordingError(f"expected a recording of Flatland, found one compressed by {name}")

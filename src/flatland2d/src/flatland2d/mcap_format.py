"""The format .mcap of Foxglove, with the profile of ROS 1 or ROS 2: https://mcap.dev/spec."""

import struct
import zlib
from typing import Dict, Iterator, Tuple

from flatland2d.recording_format import (
    LARGEST_CHUNK,
    Bytes,
    Channel,
    Damaged,
    Fields,
    Format,
    Messages,
    Recorded,
    block,
    unreadable_compression,
)
from flatland_server.exceptions import MissingPackageError

try:  # files of a fraction of the size
    import zstandard
except ImportError:
    zstandard = None

_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _MESSAGE_INDEX, _CHUNK_INDEX = range(1, 9)
_STATISTICS, _DATA_END = 0x0B, 0x0F
_RECORD = struct.Struct("<BQ")
_ZSTD = "zstd"

_PROFILES = {"ros1": ("ros1", "ros1msg"), "cdr": ("ros2", "ros2msg")}
"""The profile and the encoding of schemas, by that of messages."""

_TRANSIENT_LOCAL = """\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {sec: 0, nsec: 0}
  lifespan: {sec: 0, nsec: 0}
  liveliness: 1
  liveliness_lease_duration: {sec: 0, nsec: 0}
  avoid_ros_namespace_conventions: false
"""
"""The quality of service of a latched topic, as rosbag2 writes it."""


class McapFormat(Format):
    """An .mcap: its chunks are compressed if the package zstandard is installed."""

    magic = b"\x89MCAP0\r\n"
    encodings = tuple(_PROFILES)

    def beginning(self, index_position: int) -> bytes:
        profile, _ = _PROFILES[self._encoding]
        return self.magic + _record(_HEADER, _text(profile) + _text("flatland"))

    def index(self, position: int) -> bytes:
        end = _record(_DATA_END, bytes(4))
        parts = [self._channel_record(n, channel) for channel, n in self._channels.items()]
        parts += (chunk.entry for chunk in self.chunks)
        parts.append(_record(_STATISTICS, self._statistics()))
        footer = struct.pack("<QQI", position + len(end), 0, 0)
        return b"".join([end, *parts, _record(_FOOTER, footer), self.magic])

    @classmethod
    def read(cls, data: Bytes) -> Iterator[Recorded]:
        content = Fields(data)
        content.take(len(cls.magic))
        channels: Dict[int, Channel] = {}
        schemas: Dict[int, Tuple[str, str]] = {}
        while (code := content.number(1)) != _DATA_END:
            record = content.block(8)
            chunk = _uncompressed(record) if code == _CHUNK else Fields(b"")
            while chunk:
                code, fields = chunk.number(1), Fields(chunk.block(8))
                number = fields.number(2)
                if code == _SCHEMA:
                    name, _, definition = fields.text(), fields.text(), fields.text()
                    schemas[number] = name, definition
                elif code == _CHANNEL:
                    channels[number] = _channel(fields, schemas)
                elif code == _MESSAGE and number in channels:
                    fields.take(4)
                    nanoseconds = fields.number(8)
                    fields.take(8)
                    yield Recorded(channels[number], nanoseconds, fields.rest())

    def _channel_record(self, number: int, channel: Channel) -> bytes:
        """A channel after its schema, which has the channel's number."""
        schemas = _PROFILES[channel.encoding][1]
        schema = _text(channel.type) + _text(schemas) + _text(channel.definition)
        if channel.encoding == "cdr":
            values = {"topic_type_hash": channel.checksum}
            values["offered_qos_profiles"] = _TRANSIENT_LOCAL if channel.is_latched else ""
        else:
            values = {"callerid": "/flatland_server", "md5sum": channel.checksum}
            values["latching"] = str(int(channel.is_latched))
        metadata = b"".join(_text(name) + _text(value) for name, value in values.items())
        numbers = struct.pack("<HH", number, number)
        fields = numbers + _text(channel.topic) + _text(channel.encoding) + block(metadata)
        return _record(_SCHEMA, struct.pack("<H", number) + schema) + _record(_CHANNEL, fields)

    def _message_record(self, number: int, nanoseconds: int, data: bytes) -> bytes:
        return _record(_MESSAGE, struct.pack("<HIQQ", number, 0, nanoseconds, nanoseconds) + data)

    def _chunk_record(
        self, position: int, start: int, end: int, data: bytes, messages: Messages
    ) -> Tuple[bytes, bytes]:
        packed, compression = (zstandard.compress(data), _ZSTD) if zstandard else (data, "")
        times = struct.pack("<QQ", start, end)
        sizes = struct.pack("<QI", len(data), zlib.crc32(data)) + _text(compression)
        chunk = _record(_CHUNK, times + sizes + struct.pack("<Q", len(packed)) + packed)
        indexes, offsets, at = [], [], position + len(chunk)
        for number, each in messages.items():
            entries = b"".join(struct.pack("<QQ", time, offset) for time, offset in each)
            indexes.append(_record(_MESSAGE_INDEX, struct.pack("<H", number) + block(entries)))
            offsets.append(struct.pack("<HQ", number, at))
            at += len(indexes[-1])
        entry = b"".join(
            [
                times,
                struct.pack("<QQ", position, len(chunk)),
                block(b"".join(offsets)),
                struct.pack("<Q", at - position - len(chunk)),
                _text(compression),
                struct.pack("<QQ", len(packed), len(data)),
            ]
        )
        return b"".join([chunk, *indexes]), _record(_CHUNK_INDEX, entry)

    def _statistics(self) -> bytes:
        totals = dict.fromkeys(self._channels.values(), 0)
        for chunk in self.chunks:
            for number, count in chunk.counts.items():
                totals[number] += count
        counts = b"".join(struct.pack("<HQ", number, count) for number, count in totals.items())
        return struct.pack(
            "<QHIIIIQQ",
            sum(totals.values()),
            len(totals),
            len(totals),
            0,
            0,
            len(self.chunks),
            min((chunk.start for chunk in self.chunks), default=0),
            max((chunk.end for chunk in self.chunks), default=0),
        ) + block(counts)


def _record(code: int, content: bytes) -> bytes:
    return _RECORD.pack(code, len(content)) + content


def _text(text: str) -> bytes:
    return block(text.encode())


def _uncompressed(record: bytes) -> Fields:
    """The records of a chunk."""
    fields = Fields(record)
    fields.take(8 + 8)
    size = fields.number(8)
    if size > LARGEST_CHUNK:
        raise Damaged
    fields.take(4)
    compression, data = fields.text(), fields.block(8)
    if not compression:
        return Fields(data)
    if compression != _ZSTD:
        raise unreadable_compression(compression)
    if zstandard is None:
        raise MissingPackageError("a compressed .mcap needs zstandard: pip install zstandard")
    try:
        # As a stream: else it would take the memory that the frame tells, whatever it has.
        decompressor = zstandard.ZstdDecompressor(max_window_size=LARGEST_CHUNK)
        with decompressor.stream_reader(data) as stream:
            content = stream.read(size + 1)
    except zstandard.ZstdError:
        raise Damaged from None
    if len(content) != size:
        raise Damaged
    return Fields(content)


def _channel(fields: Fields, schemas: Dict[int, Tuple[str, str]]) -> Channel:
    name, definition = schemas.get(fields.number(2), ("", ""))
    topic, encoding, metadata = fields.text(), fields.text(), Fields(fields.block())
    values = {}
    while metadata:
        key = metadata.text()
        values[key] = metadata.text()
    if encoding == "cdr":
        is_latched = values.get("offered_qos_profiles") == _TRANSIENT_LOCAL
        checksum = values.get("topic_type_hash", "")
    else:
        is_latched, checksum = values.get("latching") == "1", values.get("md5sum", "")
    return Channel(topic, name, checksum, definition, is_latched, encoding)

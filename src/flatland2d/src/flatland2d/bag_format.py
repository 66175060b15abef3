"""The format .bag of ROS 1, version 2.0: http://wiki.ros.org/Bags/Format/2.0."""

import struct
from typing import Dict, Iterator, Tuple

from flatland2d.recording_format import (
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

_MESSAGE, _BAG, _MESSAGES_INDEX, _CHUNK, _CHUNK_INFO, _CHANNEL = (bytes([n]) for n in range(2, 8))
_U32 = struct.Struct("<I").pack
_U64 = struct.Struct("<Q").pack
_BAG_SIZE = 4096
"""The size of the bag's record without its two counts [bytes]. `rosbag reindex` writes it anew."""


class BagFormat(Format):
    """A .bag: its chunks are not compressed."""

    magic = b"#ROSBAG V2.0\n"

    def beginning(self, index_position: int) -> bytes:
        counts = {"conn_count": _U32(len(self._channels)), "chunk_count": _U32(len(self.chunks))}
        fields = _fields(op=_BAG, index_pos=_U64(index_position), **counts)
        return self.magic + block(fields) + block(b" " * (_BAG_SIZE - len(fields)))

    def index(self, position: int) -> bytes:
        channels = [self._channel_record(n, channel) for channel, n in self._channels.items()]
        return b"".join([*channels, *(chunk.entry for chunk in self.chunks)])

    @classmethod
    def read(cls, data: Bytes) -> Iterator[Recorded]:
        content = Fields(data)
        content.take(len(cls.magic))
        channels: Dict[bytes, Channel] = {}
        while content:
            fields, data = _record(content)
            if fields.get("op") != _CHUNK:
                continue
            if fields.get("compression") != b"none":
                raise unreadable_compression(f"{fields.get('compression')!r}")
            chunk = Fields(data)
            while chunk:
                fields, data = _record(chunk)
                number = fields.get("conn", b"")
                if fields.get("op") == _CHANNEL:
                    channels[number] = _channel(fields, data)
                elif fields.get("op") == _MESSAGE and number in channels:
                    time = Fields(fields.get("time", b""))
                    seconds, nanoseconds = time.number(4), time.number(4)
                    yield Recorded(channels[number], seconds * 10**9 + nanoseconds, data)

    def _channel_record(self, number: int, channel: Channel) -> bytes:
        topic = channel.topic.encode()
        connection = _fields(
            topic=topic,
            type=channel.type.encode(),
            md5sum=channel.checksum.encode(),
            message_definition=channel.definition.encode(),
            callerid=b"/flatland_server",
            latching=b"1" if channel.is_latched else b"0",
        )
        return block(_fields(op=_CHANNEL, conn=_U32(number), topic=topic)) + block(connection)

    def _message_record(self, number: int, nanoseconds: int, data: bytes) -> bytes:
        return block(_fields(op=_MESSAGE, conn=_U32(number), time=_time(nanoseconds))) + block(data)

    def _chunk_record(
        self, position: int, start: int, end: int, data: bytes, messages: Messages
    ) -> Tuple[bytes, bytes]:
        parts = [block(_fields(op=_CHUNK, compression=b"none", size=_U32(len(data)))), block(data)]
        for number, each in messages.items():
            count = _U32(len(each))
            parts.append(
                block(_fields(op=_MESSAGES_INDEX, ver=_U32(1), conn=_U32(number), count=count))
            )
            parts.append(block(b"".join(_time(time) + _U32(offset) for time, offset in each)))
        info = _fields(
            op=_CHUNK_INFO,
            ver=_U32(1),
            chunk_pos=_U64(position),
            start_time=_time(start),
            end_time=_time(end),
            count=_U32(len(messages)),
        )
        counts = b"".join(_U32(number) + _U32(len(each)) for number, each in messages.items())
        return b"".join(parts), block(info) + block(counts)


def _fields(**values: bytes) -> bytes:
    return b"".join(block(name.encode() + b"=" + value) for name, value in values.items())


def _time(nanoseconds: int) -> bytes:
    """A time; to rosbag, 0 means none: such a message would not be played."""
    seconds, rest = divmod(max(nanoseconds, 1), 1_000_000_000)
    return _U32(seconds) + _U32(rest)


def _record(content: Fields) -> Tuple[Dict[str, bytes], bytes]:
    """The next record: its header's fields, and its data."""
    return _values(content.block()), content.block()


def _channel(fields: Dict[str, bytes], data: bytes) -> Channel:
    values = {name: value.decode(errors="replace") for name, value in _values(data).items()}
    return Channel(
        fields.get("topic", b"").decode(errors="replace"),
        values.get("type", ""),
        values.get("md5sum", ""),
        values.get("message_definition", ""),
        values.get("latching") == "1",
    )


def _values(data: bytes) -> Dict[str, bytes]:
    fields, values = Fields(data), {}
    while fields:
        name, equals, value = fields.block().partition(b"=")
        if not equals:
            raise Damaged
        values[name.decode(errors="replace")] = value
    return values

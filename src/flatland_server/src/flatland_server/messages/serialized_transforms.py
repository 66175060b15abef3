"""The /tf message of a step, its bytes written at once."""

import math
import struct
from typing import Dict, Iterable, List, Sequence, Tuple

from flatland_server.geometry import Transform, quaternion
from flatland_server.transport.node import Frames

_HEADER = struct.Struct("<III")  # seq, secs, nsecs
_PLACE = struct.Struct("<7d")


class TransformQueue:
    """Gathers the transforms of a step as bytes; it remembers those of frames' names."""

    def __init__(self) -> None:
        self._names: Dict[Tuple[str, str], bytes] = {}
        self._parts: List[bytes] = []
        self._count = 0

    def add(self, transform: Transform) -> None:
        """Appends a transform."""
        seconds, nanoseconds = divmod(transform.nanoseconds, 1_000_000_000)
        pose = transform.pose
        turn = quaternion(pose.yaw, transform.roll)
        self.add_bytes(
            1,
            _HEADER.pack(0, seconds, nanoseconds)
            + self.names_of(transform.parent, transform.child)
            + _PLACE.pack(pose.x, pose.y, 0.0, *turn),
        )

    def add_bytes(self, count: int, data: bytes) -> None:
        """Appends so many transforms that are serialised already."""
        self._parts.append(data)
        self._count += count

    def take(self) -> bytes:
        """The message of those gathered since the last time; empty if there are none."""
        if not self._parts:
            return b""
        message = struct.pack("<I", self._count) + b"".join(self._parts)
        self._parts.clear()
        self._count = 0
        return message

    def names_of(self, parent: str, child: str) -> bytes:
        """What stands between a transform's time and its place."""
        names = self._names.get((parent, child))
        if names is None:
            encoded = [name.encode() for name in (parent, child)]
            names = b"".join(struct.pack("<I", len(name)) + name for name in encoded)
            self._names[parent, child] = names
        return names


class SerializedFrames(Frames):
    """Frames whose bytes are there but for times and places.

    Args:
        queue: where they are sent to.
        names: the parent and the child of each.
    """

    def __init__(self, queue: TransformQueue, names: Sequence[Tuple[str, str]]) -> None:
        self._queue = queue
        self._data = bytearray()
        self._offsets: List[Tuple[int, int]] = []  # of times and of places
        for parent, child in names:
            between = queue.names_of(parent, child)
            begin = len(self._data)
            self._offsets.append((begin, begin + _HEADER.size + len(between)))
            self._data += bytes(_HEADER.size) + between + bytes(_PLACE.size)

    def send(self, nanoseconds: int, poses: Iterable[Tuple[float, float, float]]) -> None:
        seconds, rest = divmod(nanoseconds, 1_000_000_000)
        data = self._data
        for (header, place), (x, y, yaw) in zip(self._offsets, poses):
            half = yaw / 2
            _HEADER.pack_into(data, header, 0, seconds, rest)
            _PLACE.pack_into(data, place, x, y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half))
        self._queue.add_bytes(len(self._offsets), bytes(data))

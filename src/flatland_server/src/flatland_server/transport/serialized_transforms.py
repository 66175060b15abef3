"""The transforms of a step, serialized directly into one /tf message."""

import math
import struct
from typing import Dict, Iterable, List, Optional, Sequence, Tuple

from flatland_server._core import BodyMessage, RelativePoses, StepMessage, TransformList
from flatland_server.geometry import Transform, quaternion
from flatland_server.messages.stamps import stamp_of
from flatland_server.transport.transport import Frames

_HEADER = struct.Struct("<III")  # seq, secs, nsecs
_POSE = struct.Struct("<7d")


class TransformQueue:
    """Collects the serialized transforms of a step; caches the serialized names of frames."""

    def __init__(self) -> None:
        self._names: Dict[Tuple[str, str], bytes] = {}
        self.list = TransformList()
        """The transforms; the core adds to it, too."""
        self.take = self.list.take
        """Returns and forgets the collected transforms as a message; empty if there are none."""

    def add(self, transform: Transform) -> None:
        """Appends a transform."""
        pose = transform.pose
        rotation = quaternion(pose.yaw, transform.roll)
        self.list.add(
            1,
            _HEADER.pack(0, *stamp_of(transform.nanoseconds))
            + self.names_of(transform.parent, transform.child)
            + _POSE.pack(pose.x, pose.y, 0.0, *rotation),
        )

    def names_of(self, parent: str, child: str) -> bytes:
        """The serialized names of two frames, which follow the stamp in a transform."""
        names = self._names.get((parent, child))
        if names is None:
            encoded = [name.encode() for name in (parent, child)]
            names = b"".join(struct.pack("<I", len(name)) + name for name in encoded)
            self._names[parent, child] = names
        return names


class SerializedFrames(Frames):
    """Frames serialized in advance, except for their stamps and poses.

    Args:
        queue: queue that gets the transforms.
        names: (parent, child) of each frame.
    """

    def __init__(self, queue: TransformQueue, names: Sequence[Tuple[str, str]]) -> None:
        self._queue = queue
        self._data = bytearray()
        self._offsets: List[Tuple[int, int]] = []  # of stamps and of poses
        for parent, child in names:
            serialized_names = queue.names_of(parent, child)
            begin = len(self._data)
            self._offsets.append((begin, begin + _HEADER.size + len(serialized_names)))
            self._data += bytes(_HEADER.size) + serialized_names + bytes(_POSE.size)
        self._poses: Optional[RelativePoses] = None
        self._message: Optional[BodyMessage] = None  # with these poses

    def send(self, nanoseconds: int, poses: Iterable[Tuple[float, float, float]]) -> None:
        if isinstance(poses, RelativePoses):
            self._queue.list.add(len(self._offsets), self._message_of(poses).data(nanoseconds))
            return
        seconds, rest = stamp_of(nanoseconds)
        data = self._data
        for (stamp, pose), (x, y, yaw) in zip(self._offsets, poses):
            half = yaw / 2
            _HEADER.pack_into(data, stamp, 0, seconds, rest)
            _POSE.pack_into(data, pose, x, y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half))
        self._queue.list.add(len(self._offsets), bytes(data))

    def step_message(self, poses: RelativePoses) -> StepMessage:
        return StepMessage(self._message_of(poses), self._queue.list)

    def _message_of(self, poses: RelativePoses) -> BodyMessage:
        if self._message is None or poses is not self._poses:
            fields = [(stamp, pose, None) for stamp, pose in self._offsets]
            self._message = BodyMessage(bytes(self._data), poses, fields, is_numbered=False)
            self._poses = poses
        return self._message

"""The /tf message of a step, its bytes written at once."""

import struct
from typing import Dict, Iterable, Tuple

from tf2_msgs.msg import TFMessage

from flatland_server.geometry import Transform, quaternion
from flatland_server.ros.prepared_message import PreparedMessage

_HEADER = struct.Struct("<III")  # seq, secs, nsecs
_PLACE = struct.Struct("<7d")


class TransformSerializer:
    """Makes TFMessages; it remembers the bytes of frames' names."""

    def __init__(self) -> None:
        self._names: Dict[Tuple[str, str], bytes] = {}

    def message_of(self, transforms: Iterable[Transform]) -> "SerializedTFMessage":
        """The message of these transforms."""
        parts = []
        for transform in transforms:
            seconds, nanoseconds = divmod(transform.nanoseconds, 1_000_000_000)
            parts.append(_HEADER.pack(0, seconds, nanoseconds))
            parts.append(self._names_of(transform.parent, transform.child))
            pose = transform.pose
            turn = quaternion(pose.yaw, transform.roll)
            parts.append(_PLACE.pack(pose.x, pose.y, 0.0, *turn))
        count = len(parts) // 3
        return SerializedTFMessage(struct.pack("<I", count) + b"".join(parts))

    def _names_of(self, parent: str, child: str) -> bytes:
        names = self._names.get((parent, child))
        if names is None:
            encoded = [name.encode() for name in (parent, child)]
            names = b"".join(struct.pack("<I", len(name)) + name for name in encoded)
            self._names[parent, child] = names
        return names


class SerializedTFMessage(PreparedMessage, TFMessage):
    """A TFMessage that rospy sends as it is."""

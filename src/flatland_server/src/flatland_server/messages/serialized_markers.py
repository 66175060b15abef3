"""Marker arrays whose bytes are there already: rospy would serialise each point by itself."""

import struct
from io import BytesIO
from typing import Iterable, List, NamedTuple

from visualization_msgs.msg import Marker, MarkerArray

from flatland_server.geometry import Pose, quaternion
from flatland_server.messages.prepared_message import PreparedMessage

_POSE = struct.Struct("<7d")


class SerializedMarkerArray(PreparedMessage, MarkerArray):  # type: ignore[misc]
    """A MarkerArray that rospy sends as it is."""


class MarkerBytes(NamedTuple):
    """Some markers, as a MarkerArray has them after its length."""

    number: int
    data: bytes


def array_of(parts: Iterable[MarkerBytes]) -> SerializedMarkerArray:
    """The message of these markers together."""
    parts = list(parts)
    length = struct.pack("<I", sum(part.number for part in parts))
    return SerializedMarkerArray(length + b"".join(part.data for part in parts))


def serialized(markers: List[Marker]) -> MarkerBytes:
    """Markers that do not change."""
    buffer = BytesIO()
    for marker in markers:
        marker.serialize(buffer)
    return MarkerBytes(len(markers), buffer.getvalue())


class MovingMarkers:
    """Markers of which nothing changes but their poses.

    Args:
        markers: as they are otherwise.
    """

    def __init__(self, markers: List[Marker]) -> None:
        self._data = bytearray()
        self._offsets: List[int] = []  # of the poses
        for marker in markers:
            # In a Marker the pose comes after header (seq, stamp, frame_id), ns, id, type, action.
            texts = len(marker.header.frame_id.encode()) + len(marker.ns.encode())
            self._offsets.append(len(self._data) + 12 + 4 + 4 + texts + 12)
            self._data += serialized([marker]).data

    def place(self, poses: Iterable[Pose]) -> MarkerBytes:
        """The markers at these poses, one for each."""
        for offset, pose in zip(self._offsets, poses):
            _POSE.pack_into(self._data, offset, pose.x, pose.y, 0.0, *quaternion(pose.yaw))
        return MarkerBytes(len(self._offsets), bytes(self._data))

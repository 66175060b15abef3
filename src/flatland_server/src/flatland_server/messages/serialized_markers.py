"""Marker arrays serialized in advance: rospy would serialize them point by point."""

import struct
from io import BytesIO
from typing import Iterable, List, NamedTuple

from visualization_msgs.msg import Marker, MarkerArray

from flatland_server.geometry import Pose, quaternion
from flatland_server.messages.prepared_message import PreparedMessage

_POSE = struct.Struct("<7d")


class SerializedMarkerArray(PreparedMessage, MarkerArray):  # type: ignore[misc]
    """A MarkerArray that is serialized already."""


class MarkerBytes(NamedTuple):
    """Serialized markers, in the form in which they follow the length in a MarkerArray."""

    number: int
    data: bytes


def array_of(parts: Iterable[MarkerBytes]) -> SerializedMarkerArray:
    """One message with the markers of all parts."""
    parts = list(parts)
    length = struct.pack("<I", sum(part.number for part in parts))
    return SerializedMarkerArray(length + b"".join(part.data for part in parts))


def serialized(markers: List[Marker]) -> MarkerBytes:
    """Serializes markers."""
    buffer = BytesIO()
    for marker in markers:
        marker.serialize(buffer)
    return MarkerBytes(len(markers), buffer.getvalue())


class MovingMarkers:
    """Serialized markers of which only the poses change.

    Args:
        markers: the markers, with any pose.
    """

    def __init__(self, markers: List[Marker]) -> None:
        self._data = bytearray()
        self._offsets: List[int] = []  # of the poses
        for marker in markers:
            # In a Marker the pose comes after header (seq, stamp, frame_id), ns, id, type, action.
            strings = len(marker.header.frame_id.encode()) + len(marker.ns.encode())
            self._offsets.append(len(self._data) + 12 + 4 + 4 + strings + 12)
            self._data += serialized([marker]).data

    def place(self, poses: Iterable[Pose]) -> MarkerBytes:
        """Returns the markers with new poses, one for each marker, in its order."""
        for offset, pose in zip(self._offsets, poses):
            _POSE.pack_into(self._data, offset, pose.x, pose.y, 0.0, *quaternion(pose.yaw))
        return MarkerBytes(len(self._offsets), bytes(self._data))

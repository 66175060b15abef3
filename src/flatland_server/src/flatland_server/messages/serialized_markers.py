"""Marker arrays serialized in advance: rospy would serialize them point by point."""

import struct
from io import BytesIO
from typing import Any, Callable, Iterable, List, NamedTuple

from flatland_server.geometry import Pose, quaternion
from flatland_server.messages.conversions import FRAME_ID
from flatland_server.messages.message_types import get
from flatland_server.messages.wire_form import LENGTH

Header = get("std_msgs/Header")
Marker = get("visualization_msgs/Marker")
MarkerArray = get("visualization_msgs/MarkerArray")

_POSE = struct.Struct("<7d")


class SerializedMarkerArray(MarkerArray):  # type: ignore[misc, valid-type]
    """A MarkerArray that is serialized already."""

    def __init__(self, data: bytes) -> None:
        super().__init__()
        self._data = data

    def serialize(self, buff: Any) -> None:
        """Writes the array into a buffer; called by rospy."""
        buff.write(self._data)


class LazyMarkerArray(MarkerArray):  # type: ignore[misc, valid-type]
    """A MarkerArray that is made when it is sent, hence never without subscribers.

    Args:
        make: returns the array. rospy calls it on a thread of its own when a subscriber connects to
            a latched topic, so it must not read what the simulation changes.
    """

    __slots__ = ["_make"]

    def __init__(self, make: Callable[[], SerializedMarkerArray]) -> None:
        super().__init__()
        self._make = make

    def serialize(self, buff: Any) -> None:
        """Writes the array into a buffer; called by rospy."""
        self._make().serialize(buff)


class MarkerBytes(NamedTuple):
    """Serialized markers, in the form in which they follow the length in a MarkerArray."""

    number: int
    data: bytes


def array_of(parts: Iterable[MarkerBytes]) -> SerializedMarkerArray:
    """One message with the markers of all parts."""
    parts = list(parts)
    length = LENGTH.pack(sum(part.number for part in parts))
    return SerializedMarkerArray(length + b"".join(part.data for part in parts))


def serialized(markers: List[Any]) -> MarkerBytes:
    """Serializes markers."""
    buffer = BytesIO()
    for marker in markers:
        marker.serialize(buffer)
    return MarkerBytes(len(markers), buffer.getvalue())


# Without a known frame, rviz would process it before those that it is to delete.
DELETE_ALL = serialized([Marker(action=Marker.DELETEALL, header=Header(frame_id=FRAME_ID))])
"""A marker at which rviz deletes all markers of the topic."""


class MovingMarkers:
    """Serialized markers of which only the poses change.

    Args:
        markers: the markers, with any pose.
    """

    def __init__(self, markers: List[Any]) -> None:
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

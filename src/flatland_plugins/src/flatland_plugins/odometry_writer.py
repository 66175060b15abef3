"""Messages of odometry, written fast."""

import struct
from io import BytesIO
from typing import Any, Callable, Optional, Sequence, Tuple, Union

from flatland_server import (
    BodyMessage,
    MessageWriter,
    Pose,
    RelativePoses,
    fill_pose,
    fill_twist,
    header,
    messages,
    quaternion,
    stamp_of,
)

Odometry = messages.get("nav_msgs/Odometry")
TwistWithCovarianceStamped = messages.get("geometry_msgs/TwistWithCovarianceStamped")

Twist = Tuple[float, float, float]

_HEADER = struct.Struct("<3I")  # seq, secs, nsecs
_POSE = struct.Struct("<7d")
_TWIST = struct.Struct("<6d")
_COVARIANCE = struct.calcsize("<36d")


class OdometryWriter(MessageWriter):
    """Makes Odometry messages that differ in their times, poses and twists alone.

    Args:
        frame_id: of the pose.
        child_frame_id: of the twist.
        pose_covariance: 6 x 6, row by row.
        twist_covariance: the same.
    """

    def __init__(
        self,
        frame_id: str,
        child_frame_id: str,
        pose_covariance: Sequence[float],
        twist_covariance: Sequence[float],
    ) -> None:
        self._frame_id = frame_id
        self._child_frame_id = child_frame_id
        self._pose_covariance = pose_covariance
        self._twist_covariance = twist_covariance
        self._sequence = 0
        self._data = bytearray()  # of the last message
        # Each with its length before it, the frames' names come between the header and the pose.
        names = len(frame_id.encode()) + len(child_frame_id.encode())
        self._pose_at = _HEADER.size + 4 + 4 + names
        self._twist_at = self._pose_at + _POSE.size + _COVARIANCE
        self.fields = (0, self._pose_at, self._twist_at)
        """The offsets of the header, the pose and the twist."""

    def message(self, nanoseconds: int, pose: Pose, twist: Twist) -> Any:
        """The message as an object."""
        message = Odometry(
            header=header(nanoseconds, self._frame_id), child_frame_id=self._child_frame_id
        )
        fill_pose(message.pose.pose, pose)
        message.pose.covariance = self._pose_covariance
        fill_twist(message.twist.twist, *twist)
        message.twist.covariance = self._twist_covariance
        return message

    def data(self, nanoseconds: int, pose: Pose, twist: Twist) -> bytes:
        """The message as bytes."""
        self._sequence += 1
        data = self._data
        if not data:
            data += _serialized(self.message(nanoseconds, pose, twist))
        _HEADER.pack_into(data, 0, self._sequence, *stamp_of(nanoseconds))
        _POSE.pack_into(data, self._pose_at, pose.x, pose.y, 0.0, *quaternion(pose.yaw))
        vx, vy, omega = twist
        _TWIST.pack_into(data, self._twist_at, vx, vy, 0.0, 0.0, 0.0, omega)
        return bytes(data)


class TwistWriter(MessageWriter):
    """Makes TwistWithCovarianceStamped messages that differ in their times and twists alone.

    Args:
        frame_id: of the twist.
        covariance: 6 x 6, row by row.
    """

    def __init__(self, frame_id: str, covariance: Sequence[float]) -> None:
        self._frame_id = frame_id
        self._covariance = covariance
        self._sequence = 0
        self._data = bytearray()  # of the last message
        self._twist_at = _HEADER.size + 4 + len(frame_id.encode())
        self.fields = (0, None, self._twist_at)
        """The offsets of the header, the pose (none) and the twist."""

    def message(self, nanoseconds: int, twist: Twist) -> Any:
        """The message as an object."""
        message = TwistWithCovarianceStamped(header=header(nanoseconds, self._frame_id))
        fill_twist(message.twist.twist, *twist)
        message.twist.covariance = self._covariance
        return message

    def data(self, nanoseconds: int, twist: Twist) -> bytes:
        """The message as bytes."""
        self._sequence += 1
        data = self._data
        if not data:
            data += _serialized(self.message(nanoseconds, twist))
        _HEADER.pack_into(data, 0, self._sequence, *stamp_of(nanoseconds))
        vx, vy, omega = twist
        _TWIST.pack_into(data, self._twist_at, vx, vy, 0.0, 0.0, 0.0, omega)
        return bytes(data)


class BodyWriter(MessageWriter):
    """Makes the messages of another writer, with values that the core reads from a body.

    Args:
        writer: makes the same messages from values.
        motion: of the body, in the world.
        values: returns the present values, for messages as objects.
        twist_in_local_frame: whether the twist is in the frame of the body.
    """

    def __init__(
        self,
        writer: Union[OdometryWriter, TwistWriter],
        motion: RelativePoses,
        values: Callable[[], Tuple[Any, ...]],
        twist_in_local_frame: bool = True,
    ) -> None:
        self._writer = writer
        self._motion = motion
        self._values = values
        self._twist_in_local_frame = twist_in_local_frame
        self._message: Optional[BodyMessage] = None

    def message(self, nanoseconds: int) -> Any:
        """The message as an object."""
        return self._writer.message(nanoseconds, *self._values())

    def data(self, nanoseconds: int) -> bytes:
        """The message as bytes."""
        return self.body_message.data(nanoseconds)

    @property
    def body_message(self) -> BodyMessage:
        """The message that the core writes."""
        if self._message is None:  # most are never written
            constant = _serialized(self.message(0))
            fields, is_local = [self._writer.fields], self._twist_in_local_frame
            self._message = BodyMessage(constant, self._motion, fields, is_local)
        return self._message


def _serialized(message: Any) -> bytes:
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()

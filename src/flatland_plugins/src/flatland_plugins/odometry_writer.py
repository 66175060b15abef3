"""Messages of a body's motion, written fast."""

import math
import struct
from io import BytesIO
from typing import Any, Callable, NamedTuple, Optional, Sequence, Tuple

from flatland_server import (
    BodyMessage,
    MessageWriter,
    Pose,
    RelativePoses,
    Velocity,
    fill_pose,
    fill_twist,
    header,
    messages,
    quaternion,
    stamp_of,
)

OdometryMessage = messages.get("nav_msgs/Odometry")
TwistMessage = messages.get("geometry_msgs/TwistWithCovarianceStamped")

_HEADER = struct.Struct("<3I")  # seq, secs, nsecs
_POSE = struct.Struct("<7d")
_TWIST = struct.Struct("<6d")
_COVARIANCE = struct.calcsize("<36d")


class Odometry(NamedTuple):
    """Pose and velocity of a body."""

    pose: Pose
    """In the frame of odometry, or in the world."""
    velocity: Velocity
    """In the frame of the body."""


class MotionWriter(MessageWriter):
    """Makes messages that differ in their times, poses and twists alone.

    Their values are given, or those that the core reads from the body.

    Args:
        make: makes an Odometry or a TwistWithCovarianceStamped of a time [ns], with the constants.
        poses: the pose of the body in the world.
        read: returns the present motion, for messages as objects.
        is_local: whether the twist is in the frame of the body, instead of that of the pose.
    """

    def __init__(
        self,
        make: Callable[[int], Any],
        poses: RelativePoses,
        read: Callable[[], Odometry],
        is_local: bool = True,
    ) -> None:
        self._make = make
        self._poses = poses
        self._read = read
        self._is_local = is_local
        self._sequence = 0
        self._data = bytearray()  # of the last message
        self._message: Optional[BodyMessage] = None
        empty = make(0)
        self._has_pose = hasattr(empty, "pose")
        frames = [empty.header.frame_id, *([empty.child_frame_id] if self._has_pose else [])]
        self._pose_at = _HEADER.size + sum(4 + len(frame.encode()) for frame in frames)
        self._twist_at = self._pose_at + (_POSE.size + _COVARIANCE if self._has_pose else 0)

    def message(self, nanoseconds: int, motion: Optional[Odometry] = None) -> Any:
        """The message as an object."""
        motion = motion or self._read()
        message = self._make(nanoseconds)
        if self._has_pose:
            fill_pose(message.pose.pose, motion.pose)
        fill_twist(message.twist.twist, *self._twist(motion))
        return message

    def data(self, nanoseconds: int, motion: Optional[Odometry] = None) -> bytes:
        """The message as bytes."""
        if motion is None:
            return self.body_message.data(nanoseconds)
        self._sequence += 1
        data = self._data
        if not data:
            data += _serialized(self.message(nanoseconds, motion))
        _HEADER.pack_into(data, 0, self._sequence, *stamp_of(nanoseconds))
        if self._has_pose:
            x, y, yaw = motion.pose
            _POSE.pack_into(data, self._pose_at, x, y, 0.0, *quaternion(yaw))
        vx, vy, omega = self._twist(motion)
        _TWIST.pack_into(data, self._twist_at, vx, vy, 0.0, 0.0, 0.0, omega)
        return bytes(data)

    @property
    def body_message(self) -> BodyMessage:
        """The message that the core writes, with the values that it reads."""
        if self._message is None:  # most are never written
            fields = (0, self._pose_at if self._has_pose else None, self._twist_at)
            constant = _serialized(self.message(0))
            self._message = BodyMessage(constant, self._poses, [fields], self._is_local)
        return self._message

    def _twist(self, motion: Odometry) -> Tuple[float, float, float]:
        vx, vy, omega = motion.velocity
        if self._is_local:
            return vx, vy, omega
        cos, sin = math.cos(motion.pose.yaw), math.sin(motion.pose.yaw)
        return cos * vx - sin * vy, sin * vx + cos * vy, omega


def odometry_maker(
    frame_id: str,
    child_frame_id: str,
    pose_covariance: Sequence[float],
    twist_covariance: Sequence[float],
) -> Callable[[int], Any]:
    """Makes Odometry messages of a time.

    Args:
        frame_id: frame of the pose.
        child_frame_id: frame of the twist.
        pose_covariance: 6 x 6, row by row.
        twist_covariance: 6 x 6, row by row.
    """

    def make(nanoseconds: int) -> Any:
        message = OdometryMessage(
            header=header(nanoseconds, frame_id), child_frame_id=child_frame_id
        )
        message.pose.covariance = pose_covariance
        message.twist.covariance = twist_covariance
        return message

    return make


def twist_maker(frame_id: str, covariance: Sequence[float]) -> Callable[[int], Any]:
    """Makes TwistWithCovarianceStamped messages of a time.

    Args:
        frame_id: frame of the twist.
        covariance: 6 x 6, row by row.
    """

    def make(nanoseconds: int) -> Any:
        message = TwistMessage(header=header(nanoseconds, frame_id))
        message.twist.covariance = covariance
        return message

    return make


def _serialized(message: Any) -> bytes:
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()

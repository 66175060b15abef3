"""Conversions of Flatland's values into messages.

Stamps, the times in messages and transforms, are equal to simulated times, unless the server stamps
with real time (`WallTimekeeper`): then there is an offset between them. It is one of the process,
as ROS's own clock is.
"""

import math
from typing import Any, Tuple

from flatland_server import _core
from flatland_server.geometry import Pose, Transform, quaternion
from flatland_server.messages.message_types import TYPES

FRAME_ID = "map"
"""The frame of the world."""

_offset = 0  # of stamps [ns]


def stamp_of(nanoseconds: int) -> Tuple[int, int]:
    """The stamp of a simulated time: seconds, and nanoseconds in [0, 1e9).

    Args:
        nanoseconds: simulated time [ns].
    """
    return divmod(nanoseconds + _offset, 1_000_000_000)


def stamp_offset() -> int:
    """The difference between stamps and simulated time [ns]."""
    return _offset


def set_stamp_offset(nanoseconds: int) -> None:
    """Sets the difference between stamps and simulated time [ns], of Python and of the core."""
    global _offset
    _offset = nanoseconds
    _core.set_stamp_offset(nanoseconds)


def ros_time(nanoseconds: int) -> Any:
    """The stamp of a simulated time, as a ROS time.

    Args:
        nanoseconds: simulated time [ns].
    """
    return TYPES.Time(*stamp_of(nanoseconds))


def header(nanoseconds: int, frame_id: str) -> Any:
    """A header with stamp and frame.

    Args:
        nanoseconds: simulated time [ns].
        frame_id: name of the frame.
    """
    return TYPES.get("std_msgs/Header")(stamp=ros_time(nanoseconds), frame_id=frame_id)


def fill_pose(message: Any, pose: Tuple[float, float, float]) -> None:
    """Writes a pose into a message.

    Args:
        message: geometry_msgs/Pose to write to.
        pose: [m, m, rad]; also that of a physics body.
    """
    message.position.x, message.position.y, yaw = pose
    orientation = message.orientation
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion(yaw)


def yaw_of(orientation: Any) -> float:
    """The yaw of a quaternion, within [-pi, pi] [rad].

    The angle of the turned x axis: atan2 of the entries (2, 1) and (1, 1) of the rotation matrix.

    Args:
        orientation: a geometry_msgs/Quaternion of length 1.
    """
    q = orientation
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def transform_of(message: Any) -> Transform:
    """A transform in the plane.

    Args:
        message: a geometry_msgs/TransformStamped; its height and pitch are ignored.
    """
    translation, q = message.transform.translation, message.transform.rotation
    stamp = message.header.stamp
    return Transform(
        stamp.secs * 1_000_000_000 + stamp.nsecs,
        message.header.frame_id,
        message.child_frame_id,
        Pose(translation.x, translation.y, yaw_of(q)),
        2.0 * math.atan2(math.hypot(q.x, q.y), math.hypot(q.z, q.w)),
    )


def fill_twist(message: Any, vx: float, vy: float, omega: float) -> None:
    """Writes a planar velocity into a message.

    Args:
        message: geometry_msgs/Twist to write to.
        vx: [m/s].
        vy: [m/s].
        omega: [rad/s].
    """
    message.linear.x, message.linear.y, message.angular.z = vx, vy, omega

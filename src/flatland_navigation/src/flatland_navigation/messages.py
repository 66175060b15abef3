"""Conversions between ROS messages and poses in the plane."""

import math
from typing import Any

from flatland_server import Pose, yaw_of


def to_pose(message: Any) -> Pose:
    """The pose in the plane of a geometry_msgs/Pose.

    Raises:
        ValueError: a value is not finite, or the quaternion is zero.
    """
    q = message.orientation
    if abs(math.sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w) - 1.0) > 0.1:
        raise ValueError(
            f"expected an orientation of length 1, found the quaternion "
            f"({q.x:g}, {q.y:g}, {q.z:g}, {q.w:g})"
        )
    pose = Pose(message.position.x, message.position.y, yaw_of(q))
    if not pose.is_finite():
        raise ValueError(f"expected finite numbers, found ({pose.x:g}, {pose.y:g})")
    return pose


def transform_to_pose(message: Any) -> Pose:
    """The pose in the plane of a geometry_msgs/Transform."""
    translation = message.translation
    return Pose(translation.x, translation.y, yaw_of(message.rotation))


def is_upside_down(message: Any) -> bool:
    """True if a geometry_msgs/Transform turns the z axis downwards."""
    q = message.rotation
    return bool(q.x * q.x + q.y * q.y > 0.5)

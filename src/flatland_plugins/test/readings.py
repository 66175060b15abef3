"""Poses in the plane and stamps, read from messages."""

import math
from typing import Any, Optional, Tuple

from geometry_msgs.msg import Transform
from tf2_msgs.msg import TFMessage

Pose = Tuple[float, float, float]  # m, m, rad


def turned(
    point: Tuple[float, float], angle: float, about: Tuple[float, float] = (0.0, 0.0)
) -> Tuple[float, float]:
    """A point of a frame that is turned by `angle`, its origin at `about`."""
    (x, y), cos, sin = point, math.cos(angle), math.sin(angle)
    return about[0] + cos * x - sin * y, about[1] + sin * x + cos * y


def yaw_of(quaternion: Any) -> float:
    """The heading that a quaternion about z stands for."""
    return 2.0 * math.atan2(quaternion.z, quaternion.w)


def pose_of(message: Any) -> Pose:
    """The pose in the plane of a geometry_msgs/Pose or Transform."""
    if isinstance(message, Transform):
        return message.translation.x, message.translation.y, yaw_of(message.rotation)
    return message.position.x, message.position.y, yaw_of(message.orientation)


def seen_from(pose: Pose, other: Pose) -> Pose:
    """Another pose, in the frame of a pose."""
    x, y = turned((other[0] - pose[0], other[1] - pose[1]), -pose[2])
    return x, y, other[2] - pose[2]


def stamp_of(message: Any) -> Optional[int]:
    """A message's stamp [ns], if it has one; the transforms of one message are of one time."""
    if isinstance(message, TFMessage):
        message = message.transforms[0]
    return message.header.stamp.to_nsec() if hasattr(message, "header") else None

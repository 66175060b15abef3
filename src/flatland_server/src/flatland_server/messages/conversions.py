"""Conversions of Flatland's values into ROS messages. No ROS master is needed."""

from typing import Any

from genpy import Time
from std_msgs.msg import Header

from flatland_server.geometry import Pose, quaternion


def ros_time(nanoseconds: int) -> Time:
    """Simulated time as a ROS time."""
    return Time(nanoseconds // 1_000_000_000, nanoseconds % 1_000_000_000)


def header(nanoseconds: int, frame_id: str) -> Header:
    """A header with stamp and frame."""
    return Header(stamp=ros_time(nanoseconds), frame_id=frame_id)


def fill_pose(message: Any, pose: Pose) -> None:
    """Writes a pose [m, rad] into a geometry_msgs/Pose."""
    message.position.x, message.position.y = pose.x, pose.y
    orientation = message.orientation
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion(pose.yaw)


def fill_twist(message: Any, vx: float, vy: float, omega: float) -> None:
    """Writes a planar velocity [m/s, m/s, rad/s] into a geometry_msgs/Twist."""
    message.linear.x, message.linear.y, message.angular.z = vx, vy, omega

"""ROS messages from Flatland's values. Message classes need no ROS master."""

import struct
from typing import Any

import numpy as np
from genpy import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from flatland_server.geometry import Pose, quaternion


def ros_time(nanoseconds: int) -> Time:
    """Simulated time as a ROS time."""
    return Time(nanoseconds // 1_000_000_000, nanoseconds % 1_000_000_000)


def header(nanoseconds: int, frame_id: str) -> Header:
    """A header with stamp and frame."""
    return Header(stamp=ros_time(nanoseconds), frame_id=frame_id)


def fill_pose(message: Any, pose: Pose) -> None:
    """Writes a pose into a geometry_msgs/Pose."""
    message.position.x, message.position.y = pose.x, pose.y
    orientation = message.orientation
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion(pose.yaw)


def fill_twist(message: Any, vx: float, vy: float, omega: float) -> None:
    """Writes a planar velocity into a geometry_msgs/Twist."""
    message.linear.x, message.linear.y, message.angular.z = vx, vy, omega


class ArrayLaserScan(LaserScan):  # type: ignore[misc]
    """A LaserScan whose ranges and intensities are arrays; it writes their bytes as they are.

    The generated code packs every number by itself, which takes longer than to cast the beams.
    """

    def serialize(self, buff: Any) -> None:
        """Writes the message, field by field as LaserScan has them."""
        header, frame = self.header, self.header.frame_id.encode()
        buff.write(
            struct.pack("<4I", header.seq, header.stamp.secs, header.stamp.nsecs, len(frame))
        )
        buff.write(frame)
        angles = (self.angle_min, self.angle_max, self.angle_increment)
        times = (self.time_increment, self.scan_time)
        buff.write(struct.pack("<7f", *angles, *times, self.range_min, self.range_max))
        for values in (self.ranges, self.intensities):
            buff.write(struct.pack("<I", len(values)))
            buff.write(np.asarray(values, dtype="<f4").tobytes())

"""ROS messages from Flatland's values, and a scan that is quick to send."""

import struct
from typing import Any

import numpy as np
from sensor_msgs.msg import LaserScan

from flatland_server.messages import fill_pose, fill_twist, header, ros_time

__all__ = ["ArrayLaserScan", "fill_pose", "fill_twist", "header", "ros_time"]


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

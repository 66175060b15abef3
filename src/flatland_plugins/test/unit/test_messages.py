"""Messages that write themselves: byte for byte what the generated code writes."""

from io import BytesIO

import numpy as np
from sensor_msgs.msg import LaserScan

from flatland_plugins.messages import ArrayLaserScan, header


def serialized(message) -> bytes:
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def test_a_scan_of_arrays_is_a_laser_scan():
    fields = {
        "header": header(12_345_678_901, "robot_läser"),
        "angle_min": -1.5,
        "angle_max": 1.25,
        "angle_increment": 0.125,
        "time_increment": 0.001,
        "scan_time": 0.1,
        "range_min": 0.05,
        "range_max": 20.0,
    }
    ranges = np.array([0.1, 2.5, np.inf, 19.999], np.float32)
    intensities = np.array([0.0, 255.0, 0.0, 255.0], np.float32)

    scan = ArrayLaserScan(ranges=ranges, intensities=intensities, **fields)

    expected = LaserScan(ranges=ranges.tolist(), intensities=intensities.tolist(), **fields)
    assert serialized(scan) == serialized(expected)
    received = LaserScan().deserialize(serialized(scan))
    assert list(received.ranges) == ranges.tolist()

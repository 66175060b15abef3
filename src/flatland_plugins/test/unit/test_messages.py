"""Writers of messages: byte for byte the same as the generated code."""

from io import BytesIO

import numpy as np
from geometry_msgs.msg import TwistWithCovarianceStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from flatland_plugins.odometry_writer import OdometryWriter, TwistWriter
from flatland_plugins.scan_writer import ScanWriter
from flatland_server import header
from flatland_server.geometry import Pose


def serialized(message) -> bytes:
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def test_a_scan_of_arrays_is_a_laser_scan():
    fields = {
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
    writer = ScanWriter("robot_läser", **fields)

    for sequence in (1, 2):
        data = writer.data(12_345_678_901, ranges, intensities)

        expected = LaserScan(ranges=ranges.tolist(), intensities=intensities.tolist(), **fields)
        expected.header = header(12_345_678_901, "robot_läser")
        expected.header.seq = sequence
        assert data == serialized(expected)

    message = writer.message(12_345_678_901, ranges, intensities)
    message.header.seq = 2
    assert serialized(message) == data


def test_odometry_is_odometry():
    covariances = [float(i) for i in range(36)], [0.5 * i for i in range(36)]
    writer = OdometryWriter("odöm", "robot_base", *covariances)

    for sequence, nanoseconds in ((1, 12_345_678_901), (2, 5)):
        pose, twist = Pose(1.5, -2.5, 0.7 * sequence), (0.25, -0.125, 3.0)
        data = writer.data(nanoseconds, pose, twist)

        received = Odometry().deserialize(data)
        assert received.header.seq == sequence
        assert received.header.stamp.to_nsec() == nanoseconds
        assert (received.header.frame_id, received.child_frame_id) == ("odöm", "robot_base")
        assert received.pose.covariance == tuple(covariances[0])
        assert received.twist.covariance == tuple(covariances[1])
        message = writer.message(nanoseconds, pose, twist)
        message.header.seq = sequence
        assert serialized(message) == data


def test_a_twist_is_a_twist_with_covariance():
    covariance = [0.5 * i for i in range(36)]
    writer = TwistWriter("röbot_base", covariance)

    for sequence, nanoseconds in ((1, 12_345_678_901), (2, 5)):
        twist = (0.25 * sequence, -0.125, 3.0)
        data = writer.data(nanoseconds, twist)

        received = TwistWithCovarianceStamped().deserialize(data)
        assert received.header.seq == sequence
        assert received.header.stamp.to_nsec() == nanoseconds
        assert received.header.frame_id == "röbot_base"
        linear, angular = received.twist.twist.linear, received.twist.twist.angular
        assert (linear.x, linear.y, angular.z) == twist
        assert received.twist.covariance == tuple(covariance)
        message = writer.message(nanoseconds, twist)
        message.header.seq = sequence
        assert serialized(message) == data

"""Writers of messages: byte for byte the same as the generated code."""

import numpy as np
import pytest

from flatland_plugins.laser import ScanWriter
from flatland_plugins.odometry_writer import MotionWriter, Odometry, odometry_maker, twist_maker
from flatland_server.geometry import Pose
from flatland_server.messages.wire_form import serialized

FIELDS = {"angle_min": -1.5, "angle_max": 1.25, "angle_increment": 0.125, "time_increment": 0.001}
FIELDS.update(scan_time=0.1, range_min=0.05, range_max=20.0)
RANGES = np.array([0.1, 2.5, np.inf, 19.999], np.float32)
COVARIANCES = [float(i) for i in range(36)], [0.5 * i for i in range(36)]
MOTIONS = (
    (Odometry(Pose(1.5, -2.5, 0.7), (0.25, -0.125, 3.0)),),
    (Odometry(Pose(0.5, 3.5, -1.4), (0.0, 1.0, 2.0)),),
)


SCANS = (RANGES, np.zeros(4, np.float32)), (RANGES[:2], RANGES[:0])
ODOMETRY = odometry_maker("odöm", "robot_base", *COVARIANCES)


@pytest.mark.parametrize(
    ("writer", "both"),
    [
        (ScanWriter("robot_läser", **FIELDS), SCANS),
        (MotionWriter(ODOMETRY, None, None), MOTIONS),
        (MotionWriter(ODOMETRY, None, None, False), MOTIONS),
        (MotionWriter(twist_maker("röbot_base", COVARIANCES[0]), None, None), MOTIONS),
    ],
    ids=["scan", "odometry", "odometry, twist in its frame", "twist"],
)
def test_bytes_are_those_of_the_message_with_the_next_number(writer, both):
    for sequence, nanoseconds, values in ((1, 12_345_678_901, both[0]), (2, 5, both[1])):
        data = writer.data(nanoseconds, *values)

        message = writer.message(nanoseconds, *values)
        assert message.header.stamp.to_nsec() == nanoseconds
        message.header.seq = sequence
        assert data == serialized(message)

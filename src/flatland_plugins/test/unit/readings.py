"""What several tests read: odometry, and the log."""

import logging
import math
from typing import Any, List, Tuple

import pytest

FILTERED, GROUND_TRUTH, TWIST = "/odometry/filtered", "/odometry/ground_truth", "/twist"


def pose_of(odometry: Any) -> Tuple[float, float, float]:
    """The pose in an Odometry, which is flat on the floor."""
    position, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    assert (q.x, q.y) == (0.0, 0.0)
    return position.x, position.y, 2.0 * math.atan2(q.z, q.w)


def twist_of(stamped: Any) -> Tuple[float, float, float]:
    """The velocity in an Odometry or a TwistStamped."""
    twist = getattr(stamped.twist, "twist", stamped.twist)
    return twist.linear.x, twist.linear.y, twist.angular.z


def warnings(caplog: pytest.LogCaptureFixture) -> List[str]:
    """What was warned of so far."""
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]

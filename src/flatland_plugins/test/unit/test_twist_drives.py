"""Behaviour common to all drives that a geometry_msgs/Twist commands."""

import math
from typing import Any

import pytest
from forklift import forklift
from geometry_msgs.msg import Twist, TwistWithCovarianceStamped
from logged import warnings
from readings import FILTERED, GROUND_TRUTH, TWIST, twist_of


@pytest.fixture(params=["DiffDrive", "OmniDrive", "TricycleDrive"])
def make(request, files):
    """Makes a robot with a drive; adds keys to the drive."""

    def with_drive(*keys: str, namespace: str = "") -> Any:
        if request.param == "TricycleDrive":
            return forklift(files, *keys, entry=f", namespace: '{namespace}'")
        drive = f"type: {request.param}, name: drive, body: base"
        return files.robot(", ".join((drive, *keys)), namespace=namespace)

    return with_drive


@pytest.mark.parametrize(
    ("linear", "angular"), [(math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (0.0, -math.inf)]
)
def test_an_impossible_command_is_ignored_with_a_warning(make, caplog, linear, angular):
    robot = make(namespace="robot1").drive(0.5, topic="/robot1/cmd_vel").run(1.0)

    robot.drive(linear, angular, topic="/robot1/cmd_vel").run(1.0)

    [message] = warnings(caplog)
    for part in ("robot1/cmd_vel", f"linear.x={linear}", f"angular.z={angular}"):
        assert part in message
    assert robot.model().pose == pytest.approx((1.0, 0.0, 0.0), abs=1e-3)


def test_only_the_first_of_several_wrong_commands_is_warned_of(make, caplog):
    robot = make()

    for speed in (math.nan, math.nan, 0.5, math.nan, math.inf):
        robot.drive(speed).run(0.1)

    assert len(warnings(caplog)) == 2


@pytest.mark.parametrize("make", ["DiffDrive", "TricycleDrive"], indirect=True)
def test_components_that_a_drive_cannot_do_are_ignored(make, caplog):
    robot = make()
    twist = Twist()
    twist.linear.x, twist.linear.y, twist.angular.x = 0.5, math.nan, math.inf

    robot.transport.send("/cmd_vel", twist)
    robot.run(1.0)

    assert warnings(caplog) == []
    assert robot.model().pose == pytest.approx((0.5, 0.0, 0.0), abs=1e-3)


def test_the_twist_has_the_covariance_of_the_odometry(make):
    noise = "odom_twist_noise: [0.01, 0.02, 0.03]"
    robot = make(noise, "enable_twist_pub: true", namespace="robot1").drive(0.5).run(0.1)

    twist, odometry = robot.last(f"/robot1{TWIST}"), robot.last(f"/robot1{FILTERED}")

    assert isinstance(twist, TwistWithCovarianceStamped)
    assert twist.header.frame_id == "robot1_base"
    assert twist.header.stamp == odometry.header.stamp
    assert twist_of(twist) == pytest.approx(twist_of(odometry), abs=1e-9)
    assert list(twist.twist.covariance) == list(odometry.twist.covariance)
    assert twist.twist.covariance[0] == 0.01


@pytest.mark.parametrize("make", ["DiffDrive"], indirect=True)
@pytest.mark.parametrize(
    ("flag", "topics", "frames"),
    [
        ("enable_odom_pub: false", {TWIST}, {"base"}),
        ("enable_twist_pub: false", {FILTERED, GROUND_TRUTH}, {"base"}),
        ("enable_odom_tf_pub: false", {FILTERED, GROUND_TRUTH, TWIST}, set()),
    ],
)
def test_flags_switch_topics_and_the_transform_off(make, flag, topics, frames):
    robot = make(flag).run()

    assert robot.transport.topics == topics
    assert set(robot.transport.transforms) == frames
    assert all(robot.last(topic) is not None for topic in topics)


def test_the_drive_stops_when_it_ends_before_its_body(make):
    robot = make("linear_dynamics: {deceleration_limit: 1}").drive(0.5).run(1.0)

    robot.world.close()
    robot.run(5.0)

    # It rolls out over v^2 / 2a.
    assert robot.model().pose == pytest.approx((0.5 + 0.125, 0.0, 0.0), abs=1e-3)

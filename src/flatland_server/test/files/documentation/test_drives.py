"""The documentation's pages about drives: the examples run, and the defaults are as stated."""

import math
from typing import Any, NamedTuple, Set, Tuple

import pytest

from flatland_plugins.drive_config import DynamicsLimits
from flatland_plugins.odometry_config import OdometryConfig

STEPS_PER_SECOND = 200
WHEELBASE = 0.83
"""Of the tutorial's cleaner [m]."""

DIFF_DRIVE = "type: DiffDrive, name: least, body: base"
TRICYCLE_DRIVE = (
    "type: TricycleDrive, name: least, body: base, front_wheel_joint: front_wheel_revolute, "
    "rear_left_wheel_joint: rear_left_wheel_weld, rear_right_wheel_joint: rear_right_wheel_weld"
)


class Drive(NamedTuple):
    """A drive.

    Attributes:
        least: its entry with the required keys only.
        example: the example of its page.
        model: the model that it is part of.
        topics: that the example publishes to.
        frames: that it publishes, as pairs of parent and child.
    """

    least: str
    example: str
    model: str
    topics: Tuple[str, ...]
    frames: Set[Tuple[str, str]]


@pytest.fixture
def diff_drive(documented) -> Drive:
    topics = ("/odometry/filtered", "/odometry/ground_truth", "/twist")
    return Drive(DIFF_DRIVE, documented.page("diff_drive"), "", topics, {("odom", "base")})


@pytest.fixture
def tricycle_drive(documented) -> Drive:
    topics = ("/odometry/filtered", "/odometry/ground_truth")
    example = documented.page("tricycle_drive")
    return Drive(TRICYCLE_DRIVE, example, documented.tricycle, topics, set())


@pytest.fixture(params=["diff_drive", "tricycle_drive"])
def drive(request) -> Drive:
    return request.getfixturevalue(request.param)


def velocity_in(odometry: Any) -> Tuple[float, float, float]:
    twist = odometry.twist.twist
    return twist.linear.x, twist.linear.y, twist.angular.z


def test_the_defaults_are_those_of_the_example(documented, drive):
    readers = [documented.reader(plugins, drive.model) for plugins in (drive.least, drive.example)]

    least, example = (OdometryConfig.read(reader) for reader in readers)

    assert least == example
    for reader in readers:
        assert reader.get_rate("pub_rate", math.inf) == math.inf
        assert DynamicsLimits.read(reader, "linear_dynamics") == (0.0, 0.0, 0.0)
        assert DynamicsLimits.read(reader, "angular_dynamics") == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("which", ["least", "example"])
def test_the_topics_and_frames_by_default_and_in_the_example(documented, drive, which):
    robot = documented.robot(getattr(drive, which), drive.model)

    odometry = robot.drive(0.5, 0.1).record("/odometry/filtered", 0.5)

    assert robot.transport.subscribed == {"/cmd_vel"}
    assert robot.transport.topics == set(drive.topics)
    assert robot.frames == drive.frames
    assert len(odometry) == 0.5 * STEPS_PER_SECOND  # at every step
    truth = robot.transport.last("/odometry/ground_truth")
    assert (odometry[-1].header.frame_id, odometry[-1].child_frame_id) == ("odom", "base")
    assert (truth.header.frame_id, truth.child_frame_id) == ("map", "base")
    # Without noise, the two are equal.
    assert odometry[-1].pose == truth.pose
    assert odometry[-1].twist == truth.twist
    assert truth.pose.pose.position.x == pytest.approx(0.25, abs=0.01)
    assert not any(truth.pose.covariance)
    assert not any(truth.twist.covariance)


@pytest.mark.parametrize("which", ["least", "example"])
def test_a_diff_drive_has_no_limits_by_default(documented, diff_drive, which):
    robot = documented.robot(getattr(diff_drive, which))

    twist = robot.drive(20.0, -5.0).record("/twist", 0.01)[-1]

    velocity = twist.twist.twist
    assert (velocity.linear.x, velocity.angular.z) == pytest.approx((20.0, -5.0))
    assert twist.header.frame_id == "base"


@pytest.mark.parametrize("which", ["least", "example"])
@pytest.mark.parametrize("steering", [0.4, -1.5])
def test_a_tricycle_has_no_limits_by_default(documented, tricycle_drive, which, steering):
    robot = documented.robot(getattr(tricycle_drive, which), tricycle_drive.model)

    odometry = robot.drive(10.0, steering).record("/odometry/filtered", 0.02)[-1]

    # The front wheel's speed, at the body's origin, in the direction in which it is steered.
    forwards, sideways = 10.0 * math.cos(steering), 10.0 * math.sin(steering)
    turning = sideways / WHEELBASE
    assert velocity_in(odometry) == pytest.approx((forwards, sideways, turning), rel=1e-3)


@pytest.mark.parametrize("section", ["linear_dynamics", "angular_dynamics"])
@pytest.mark.parametrize(
    ("deceleration", "limit"),
    [("", 2.0), (", deceleration_limit: ", 2.0), (", deceleration_limit: 0.0", 0.0)],
    ids=["not there", "left blank", "none"],
)
def test_deceleration_limit_defaults_to_acceleration_limit(
    documented, drive, section, deceleration, limit
):
    entry = f"{drive.least}, {section}: {{acceleration_limit: 2{deceleration}}}"

    limits = DynamicsLimits.read(documented.reader(entry, drive.model), section)

    assert limits == (2.0, limit, 0.0)

"""OmniDrive: any planar velocity, commanded, obeyed and within limits; the rest is DiffDrive's."""

import math
from typing import Tuple

import pytest
from logged import warnings
from readings import FILTERED, GROUND_TRUTH, TWIST, pose_of, twist_of

pytestmark = pytest.mark.slow

DRIVE = "type: OmniDrive, name: drive, body: base"


def command(robot, vx: float, vy: float, omega: float = 0.0):
    """Commands a velocity, to be obeyed from the next step on."""
    return robot.drive(vx, omega, left=vy)


def exponential(vx: float, vy: float, omega: float, time: float) -> Tuple[float, float, float]:
    """The pose after a constant twist from the origin: the exponential map of SE(2).

    Lynch and Park, "Modern Robotics", 3.3.3.
    """
    if omega == 0.0:
        return vx * time, vy * time, 0.0
    s, c = math.sin(omega * time) / omega, (1.0 - math.cos(omega * time)) / omega
    return s * vx - c * vy, c * vx + s * vy, omega * time


@pytest.mark.parametrize(
    "twist",
    [(0.5, 0.3, 0.2), (-0.4, 0.6, -0.7), (0.0, 0.5, 0.0), (0.3, -0.4, 0.0), (0.0, -0.5, 1.3)],
)
@pytest.mark.parametrize("middle", ["[0, 0]", "[0.3, -0.1]"])
def test_the_last_command_holds_and_leads_along_its_curve(files, twist, middle):
    footprint = f"{{type: circle, center: {middle}, radius: 0.2, density: 10}}"
    robot = command(files.robot(DRIVE, footprint=footprint), *twist)

    truth = robot.record(GROUND_TRUTH, 10.005)

    assert truth[-1].header.stamp.to_sec() == 10.0
    for message in truth[1:]:
        x, y, yaw = exponential(*twist, message.header.stamp.to_sec())
        assert pose_of(message)[:2] == pytest.approx((x, y), abs=1e-3)
        assert math.remainder(pose_of(message)[2] - yaw, math.tau) == pytest.approx(0.0, abs=1e-3)
        assert twist_of(message) == pytest.approx(twist, abs=1e-3)


def test_a_turn_has_limits_of_its_own(files):
    robot = files.robot(
        f"{DRIVE}, angular_dynamics: {{acceleration_limit: 0.25}}, "
        "linear_dynamics: {velocity_limit: 0.5}"
    )

    command(robot, 3.0, 4.0, 2.0).run(1.005)

    assert twist_of(robot.last(GROUND_TRUTH)) == pytest.approx((0.3, 0.4, 0.25), abs=1e-3)


@pytest.mark.parametrize(("local", "expected"), [("true", (0.3, 0.4)), ("false", (-0.4, 0.3))])
def test_odometry_has_its_twist_in_the_chosen_frame(files, local, expected):
    drive = f"{DRIVE}, twist_in_local_frame: {local}"
    robot = command(files.robot(drive, pose=f"[0, 0, {math.pi / 2}]"), 0.3, 0.4).run(0.1)

    for topic in (FILTERED, GROUND_TRUTH):
        assert twist_of(robot.last(topic))[:2] == pytest.approx(expected, abs=1e-4)
    assert twist_of(robot.last(TWIST))[:2] == pytest.approx((0.3, 0.4), abs=1e-4)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_velocity_to_the_left_that_is_no_number_is_ignored(files, caplog, bad):
    robot = command(files.robot(DRIVE), 0.3, 0.4).run(1.0)

    command(robot, 0.0, bad).run(1.0)

    [message] = warnings(caplog)
    assert message.endswith(f"ignored linear.x=0.0 linear.y={bad} angular.z=0.0")
    assert robot.model().pose == pytest.approx((0.6, 0.8, 0.0), abs=1e-3)

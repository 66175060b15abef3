"""TricycleDrive: speed and steering within limits, new ones and deprecated ones."""

import math
from typing import List

import pytest
from forklift import FIRST_LINE, LINEAR, STEERING, forklift, steer_angle
from logged import warnings
from readings import GROUND_TRUTH, twist_of


def test_the_limits_are_those_of_the_speed_and_of_the_steering(files):
    robot = forklift(files, STEERING, LINEAR)

    found = []
    for speed, angle, seconds in ((1.0, 0.6, 1.0), (1.0, 0.6, 3.0), (0.0, 0.6, 1.0)):
        robot.drive(speed, angle).run(seconds)
        vx, vy, _ = twist_of(robot.last(GROUND_TRUTH))
        found.append((math.hypot(vx, vy), steer_angle(robot)))

    # By 0.5 m/s^2 and 0.5 rad/s^2 for a second; at the end; 0.8 m/s^2 less after another second.
    expected = [(0.5, 0.25), (1.0, 0.6), (0.2, 0.6)]
    assert [pytest.approx(each, abs=5e-3) for each in expected] == found


def steering(files, *keys: str) -> List[float]:
    """The angles of the front wheel after a command, at each step."""
    robot = forklift(files, *keys).drive(0.0, 0.6)
    return [steer_angle(robot.run()) for _ in range(700)]


SPEED, ACCELERATION = "max_angular_velocity", "max_steer_acceleration"


@pytest.mark.parametrize(
    ("deprecated", "new", "limits"),
    [
        (f"{SPEED}: 0.25", "", "velocity_limit: 0.25"),
        (f"{SPEED}: 9", "velocity_limit: 0.25", "velocity_limit: 0.25"),
        (f"{SPEED}: 0.25", "velocity_limit: 0", "velocity_limit: 0.25"),
        (f"{ACCELERATION}: 0.6", "", "acceleration_limit: 0.6, deceleration_limit: 0.6"),
        (f"{ACCELERATION}: 9", "acceleration_limit: 0.6", "acceleration_limit: 0.6"),
        (
            f"{ACCELERATION}: 0.2\n    {SPEED}: 0.4",
            "deceleration_limit: 0.4",
            "acceleration_limit: 0.2, deceleration_limit: 0.4, velocity_limit: 0.4",
        ),
    ],
)
def test_deprecated_limits_are_obeyed_unless_there_are_new_ones(files, deprecated, new, limits):
    obeyed = steering(files, deprecated, f"angular_dynamics: {{{new}}}")

    assert obeyed == steering(files, f"angular_dynamics: {{{limits}}}")


def test_deprecated_limits_are_warned_of_where_they_stand(files, caplog):
    forklift(files, "max_angular_velocity: 0.25", "max_steer_acceleration: 0.6")

    where = files.folder / "robot.model.yaml"
    assert warnings(caplog) == [
        f"{where}:{FIRST_LINE}: plugins[0].max_angular_velocity: is deprecated; "
        "write angular_dynamics.velocity_limit",
        f"{where}:{FIRST_LINE + 1}: plugins[0].max_steer_acceleration: is deprecated; "
        "write angular_dynamics.acceleration_limit",
    ]


def test_new_limits_are_not_warned_of(files, caplog):
    forklift(files, STEERING, LINEAR, "max_steer_angle: 1")

    assert warnings(caplog) == []

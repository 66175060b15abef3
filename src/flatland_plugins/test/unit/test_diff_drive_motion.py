"""DiffDrive: motion by command and within limits."""

import math
from typing import Tuple

import pytest
from logged import warnings
from readings import GROUND_TRUTH, pose_of, twist_of

DRIVE = "type: DiffDrive, name: drive, body: base"


def arc(linear: float, angular: float, time: float) -> Tuple[float, float, float]:
    """The pose after driving at a constant velocity from the origin, in closed form."""
    turned = angular * time
    if angular == 0.0:
        return linear * time, 0.0, 0.0
    radius = linear / angular
    heading = math.remainder(turned, math.tau)
    return radius * math.sin(turned), radius * (1 - math.cos(turned)), heading


@pytest.mark.parametrize(
    ("linear", "angular"), [(0.3, 0.0), (0.5, 0.4), (-0.3, 0.3), (0.4, -0.5), (0.0, 2.0)]
)
def test_the_last_command_holds_and_leads_along_its_arc(empty_room, linear, angular):
    empty_room.drive(linear, angular)

    truth = empty_room.record(GROUND_TRUTH, 10.0)

    for message in truth[1:]:
        time = message.header.stamp.to_sec()
        x, y, yaw = arc(linear, angular, time)
        assert pose_of(message)[:2] == pytest.approx((x, y), abs=1e-3)
        assert math.remainder(pose_of(message)[2] - yaw, math.tau) == pytest.approx(0.0, abs=1e-3)
        assert twist_of(message) == pytest.approx((linear, 0.0, angular), abs=1e-3)


@pytest.mark.parametrize(
    ("key", "command", "component"),
    [("linear_dynamics", (2.0, 0.0), 0), ("angular_dynamics", (0.0, -2.0), 2)],
)
def test_dynamics_limits_bound_the_velocity(files, key, command, component):
    limits = "{acceleration_limit: 2, deceleration_limit: 1, velocity_limit: 0.5}"
    robot = files.robot(f"{DRIVE}, {key}: {limits}").drive(*command)
    sign = math.copysign(1.0, sum(command))

    messages = robot.record(GROUND_TRUTH, 1.0)
    robot.drive(0.0, 0.0)
    messages += robot.record(GROUND_TRUTH, 1.5)

    times = [message.header.stamp.to_sec() for message in messages]
    expected = [min(0.5, 2 * t) if t <= 1 else max(0.0, 0.5 - (t - 1)) for t in times]
    speeds = [sign * twist_of(message)[component] for message in messages]
    assert speeds == pytest.approx(expected, abs=1e-3)


def test_closing_a_drive_without_its_body_causes_no_warning(files, caplog):
    robot = files.robot(DRIVE).drive(0.5).run(1.0)

    robot.model().base.physics_body.remove()
    robot.world.close()

    assert warnings(caplog) == []


@pytest.mark.parametrize(("linear", "angular"), [(1e39, 0.0), (0.0, 1e300), (-1e300, 1.0)])
def test_a_command_beyond_float32_does_not_stall_the_robot(files, linear, angular):
    robot = files.robot(DRIVE).drive(linear, angular).run(0.1)

    robot.world.move_model("robot", robot.model().pose._replace(x=0.0, y=0.0, yaw=0.0))
    robot.drive(1.0).run(1.0)

    assert robot.model().pose == pytest.approx((1.0, 0.0, 0.0), abs=1e-2)

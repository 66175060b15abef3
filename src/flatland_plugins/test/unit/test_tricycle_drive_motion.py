"""TricycleDrive: motion about the turning centre without limits, and effects of commands."""

import math

import numpy as np
import pytest
from forklift import (
    FRONT,
    FRONT_REVERSED,
    HALF_TRACK,
    LINEAR,
    STEERING,
    WHEELBASE,
    forklift,
    steer_angle,
    twist_at,
)
from readings import GROUND_TRUTH, pose_of, twist_of

from flatland_server.geometry import Pose

pytestmark = pytest.mark.slow

# Without limits


@pytest.mark.parametrize(("speed", "angle"), [(1.5, -0.7), (-0.8, 0.5)])
@pytest.mark.parametrize("front", [FRONT, FRONT_REVERSED], ids=["wheel first", "body first"])
def test_front_wheel_and_rear_axle_circle_about_one_centre(files, speed, angle, front):
    robot = forklift(files, front=front).drive(speed, angle)

    truth = robot.record(GROUND_TRUTH, 10.005)

    # The centre is where the wheels' axles meet, beside the rear axle by L / tan a.
    centre = complex(-WHEELBASE, WHEELBASE / math.tan(angle))
    yaw_rate = speed * math.sin(angle) / WHEELBASE
    assert truth[-1].header.stamp.to_sec() == 10.0
    for message in truth:
        x, y, yaw = pose_of(message)
        turned = np.exp(1j * yaw_rate * message.header.stamp.to_sec())
        wheel = centre + (0 - centre) * turned
        axle = centre + (-WHEELBASE - centre) * turned
        assert (x, y) == pytest.approx((wheel.real, wheel.imag), abs=1e-3)
        behind = Pose(x, y, yaw).apply(-WHEELBASE, 0.0)
        assert behind == pytest.approx((axle.real, axle.imag), abs=1e-3)
        assert math.remainder(yaw - np.angle(turned), math.tau) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("ahead", [0.0, 0.5, math.pi / 2, math.pi])
def test_ahead_is_from_the_rear_axle_to_the_front_wheel(files, ahead):
    sides = (Pose(0.0, 0.0, ahead).apply(-WHEELBASE, side) for side in (HALF_TRACK, -HALF_TRACK))
    robot = forklift(files, **dict(zip(("left", "right"), sides))).drive(1.0, 0.4).run(0.5)

    omega = math.sin(0.4) / WHEELBASE
    assert robot.model().pose.yaw == pytest.approx(0.5 * omega, abs=1e-3)
    # The chord of an arc is its length by the sinc of half the turn, in the middle direction.
    half_turn = 0.25 * omega
    chord = 0.5 * math.sin(half_turn) / half_turn
    direction = ahead + 0.4 + half_turn
    expected = chord * math.cos(direction), chord * math.sin(direction)
    assert robot.model().pose[:2] == pytest.approx(expected, abs=1e-3)
    assert steer_angle(robot) == pytest.approx(math.remainder(ahead + 0.4, math.tau), abs=1e-3)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("asked", "steered"), [(0.3, 0.3), (0.5, 0.5), (0.9, 0.5), (9.0, 0.5)])
def test_it_steers_no_further_than_the_largest_angle(files, sign, asked, steered):
    robot = forklift(files, "max_steer_angle: 0.5").drive(1.0, sign * asked).run(0.1)

    assert steer_angle(robot) == pytest.approx(sign * steered, abs=1e-3)
    expected = twist_at(1.0, sign * steered)
    assert twist_of(robot.last(GROUND_TRUTH)) == pytest.approx(expected, abs=1e-3)


# Commands


@pytest.mark.parametrize("limits", [(), (STEERING, LINEAR)])
def test_a_tricycle_that_is_moved_stands_still_as_it_is_steered(files, limits):
    robot = forklift(files, *limits).drive(1.0, 0.6).run(1.2)
    steered = steer_angle(robot)

    robot.world.move_model("robot", Pose(3.0, -2.0, 2.0))

    for _ in range(30):
        robot.run(0.1)
        assert robot.model().pose == pytest.approx((3.0, -2.0, 2.0), abs=1e-3)
        assert twist_of(robot.last(GROUND_TRUTH)) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
        assert steer_angle(robot) == pytest.approx(steered, abs=1e-3)
    for name, side in (("left_wheel", HALF_TRACK), ("right_wheel", -HALF_TRACK)):
        expected = Pose(3.0, -2.0, 2.0).apply(-WHEELBASE, side)
        assert robot.model().get_body(name).pose[:2] == pytest.approx(expected, abs=1e-3)


def test_a_moved_tricycle_stands_until_the_next_command(files):
    robot = forklift(files, LINEAR).drive(1.0, 0.0).run(3.0)
    robot.world.move_model("robot", Pose(3.0, -2.0, math.pi / 2))

    robot.run(1.0).drive(1.0, 0.0).run(2.0)

    # From rest: 1 m in 2 s at 0.5 m/s^2.
    assert robot.model().pose == pytest.approx((3.0, -1.0, math.pi / 2), abs=1e-3)


def test_a_wall_stops_it(files):
    wall = f"name: walls, map: {files.walls('wall', '2 -3 2 3')}"
    robot = forklift(files, layers=(wall,)).drive(0.5, 0.0).run(6.0)

    assert robot.model().pose.x == pytest.approx(2.0 - 0.2, abs=0.02)
    assert twist_of(robot.last(GROUND_TRUTH))[0] == pytest.approx(0.0, abs=0.02)

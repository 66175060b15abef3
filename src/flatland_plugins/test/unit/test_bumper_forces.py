"""Bumper: the forces of collisions."""

import math

import pytest
from bumping import (
    BOX,
    BUMPER,
    MASS,
    RADIUS,
    STEP,
    impulse,
    now,
    press,
    record,
    throw,
    vectors,
    wall,
)


@pytest.mark.parametrize("speed", [0.5, 2.0, 10.0, 60.0])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_forces_of_a_hit_sum_to_the_change_of_momentum(files, speed, restitution):
    ball = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: {restitution}}}"
    robot = throw(files.robot(BUMPER, footprint=ball, layers=wall(files)), speed)
    bounce = restitution if speed > 1.0 else 0.0  # Box2D lets nothing bounce below 1 m/s

    given = impulse(record(robot, 2.0))

    assert robot.model().base.physics_body.velocity[0] == pytest.approx(-bounce * speed, rel=1e-4)
    assert given == pytest.approx(MASS * speed * (1.0 + bounce), rel=1e-4)


@pytest.mark.parametrize("step", [0.001, 0.005, 0.02])
def test_the_same_hit_in_longer_steps_is_a_smaller_force(files, step):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 2.0)
    robot.timekeeper = type(robot.timekeeper)(step)

    forces = [sum(each.magnitude_forces) for each in record(robot, 1.0)]

    assert max(forces) == pytest.approx(MASS * 2.0 / step, rel=1e-3)


def test_a_hit_within_a_step_adds_to_the_forces_of_the_step(files):
    # Pressed down on a floor, it flies along it into a wall: Box2D solves that step in two parts.
    robot = files.robot(BUMPER, pose="[0.6, 0.2, 0]", layers=wall(files, "-3 0 3 0", "1 -3 1 3"))
    press(robot, (0.0, -3.0), 0.5)

    press(throw(robot, 60.0), (0.0, -3.0), STEP)

    floor, ahead = sorted(now(robot), key=lambda collision: collision.contact_normals[0].x)
    assert vectors(floor.contact_normals) == [pytest.approx((0.0, -1.0), abs=1e-3)]
    assert floor.magnitude_forces == [pytest.approx(3.0, rel=1e-2)]
    assert vectors(ahead.contact_normals) == [pytest.approx((1.0, 0.0), abs=1e-3)]
    assert impulse([ahead]) == pytest.approx(MASS * 60.0, rel=1e-3)


@pytest.mark.parametrize("height", [0.0, 0.1, -0.2])
def test_two_points_share_a_push_by_the_lever_rule(files, height):
    robot = files.robot(BUMPER, footprint=BOX, pose="[0.74, 0, 0]", layers=wall(files))

    press(robot, (4.0, 0.0), 2.0, at=(0.0, height))

    # f1 + f2 = F and (f1 - f2) a = F h, with the points at +-a.
    [collision] = now(robot)
    for (_, y), force in zip(vectors(collision.contact_positions), collision.magnitude_forces):
        share = 0.5 * (1.0 + math.copysign(height / 0.25, height * y))
        assert force == pytest.approx(4.0 * share, abs=0.1)
    assert sum(collision.magnitude_forces) == pytest.approx(4.0, rel=1e-2)

"""Bumper: the times of its messages, and the forces in them."""

import math

import pytest
from bumping import (
    BOX,
    BUMPER,
    MASS,
    RADIUS,
    SKIN,
    STEP,
    impulse,
    now,
    press,
    record,
    throw,
    vectors,
    wall,
)

from flatland_plugins.bumper import Bumper


def test_by_default_it_publishes_at_every_step_colliding_or_not(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0)

    messages = robot.record("/collisions", 1.0)

    assert [m.header.stamp.to_nsec() for m in messages] == [5_000_000 * i for i in range(1, 201)]
    touches = [bool(message.collisions) for message in messages]
    first = touches.index(True)
    # 0.8 m at 1 m/s, but for the skin.
    assert messages[first].header.stamp.to_sec() == pytest.approx(0.8, abs=SKIN)
    assert touches == [False] * first + [True] * (200 - first)


def test_collisions_come_at_once_and_empty_lists_at_the_rate(files):
    robot = throw(files.robot(f"{BUMPER}, update_rate: 10", layers=wall(files)), 1.0)

    messages = robot.record("/collisions", 1.0)
    throw(robot, -1.0)
    messages += robot.record("/collisions", 1.0)

    touching = [m.header.stamp.to_nsec() for m in messages if m.collisions]
    empty = [m.header.stamp.to_nsec() for m in messages if not m.collisions]
    assert touching == list(range(touching[0], touching[-1] + 1, 5_000_000))
    assert len(touching) == pytest.approx(40, abs=5)
    # From the end of the first step on.
    due = [5_000_000 + 100_000_000 * i for i in range(20)]
    assert empty == [time for time in due if not touching[0] <= time <= touching[-1]]


def test_without_publish_all_it_publishes_at_the_rate_only(files):
    bumper = f"{BUMPER}, update_rate: 10, publish_all_collisions: false"
    robot = throw(files.robot(bumper, layers=wall(files)), 1.0)

    messages = robot.record("/collisions", 2.0)

    stamps = [message.header.stamp.to_nsec() for message in messages]
    assert stamps == [5_000_000 + 100_000_000 * i for i in range(20)]
    assert [len(message.collisions) for message in messages] == [0] * 8 + [1] * 12


@pytest.mark.parametrize(("publish_all", "is_told"), [("true", True), ("false", False)])
def test_a_hit_between_updates_needs_publish_all_collisions(files, publish_all, is_told):
    ball = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: 1}}"
    bumper = f"{BUMPER}, update_rate: 10, publish_all_collisions: {publish_all}"
    robot = files.robot(bumper, footprint=ball, layers=wall(files), pose="[0.65, 0, 0]")

    # At 3 m/s it is at the wall half way between two updates.
    assert bool(record(throw(robot, 3.0), 0.5)) == is_told
    assert robot.model().base.physics_body.velocity[0] == pytest.approx(-3.0, rel=1e-3)


def test_without_subscribers_it_is_idle_and_misses_nothing(files, no_subscribers, monkeypatch):
    calls = []
    step = Bumper.after_physics_step
    monkeypatch.setattr(
        Bumper, "after_physics_step", lambda self, time: (calls.append(time), step(self, time))
    )
    robot = throw(files.robot(BUMPER, layers=wall(files), transport=no_subscribers), 1.0)

    robot.run(1.0)

    assert len(calls) == 1  # the first step, from which its rate counts
    [bump] = robot.world.plugins_of("robot")["bumper"].read(robot.timekeeper)
    no_subscribers.set_subscribed_topics(["/collisions"])
    [collision] = robot.record("/collisions", 0.005)[0].collisions
    assert bump.forces == pytest.approx([0.0], abs=1e-3)
    assert vectors(collision.contact_positions) == list(bump.points)


def test_a_later_subscriber_does_not_shift_the_publishing_times(files, no_subscribers):
    bumper = f"{BUMPER}, update_rate: 10, publish_all_collisions: false"
    robot = files.robot(bumper, transport=no_subscribers).run(0.75)

    no_subscribers.set_subscribed_topics(["/collisions"])
    messages = robot.record("/collisions", 0.4)

    assert [m.header.stamp.to_nsec() for m in messages] == [
        5_000_000 + 100_000_000 * i for i in range(8, 12)
    ]


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

"""Bumper: the times of its messages."""

import pytest
from bumping import BUMPER, RADIUS, SKIN, record, throw, vectors, wall

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

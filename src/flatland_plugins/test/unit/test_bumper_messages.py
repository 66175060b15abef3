"""Bumper: when it says so, on which topic and in which frame; and what is refused."""

import pytest
from bumping import BUMPER, RADIUS, SKIN, now, press, record, throw, wall

# When it says so


def test_by_default_it_publishes_at_every_step_colliding_or_not(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0)

    messages = robot.record("/collisions", 1.0)

    assert [m.header.stamp.to_nsec() for m in messages] == [5_000_000 * i for i in range(1, 201)]
    touches = [bool(message.collisions) for message in messages]
    first = touches.index(True)
    # 0.8 m at 1 m/s, but for the skin.
    assert messages[first].header.stamp.to_sec() == pytest.approx(0.8, abs=SKIN)
    assert touches == [False] * first + [True] * (200 - first)


def test_all_collisions_are_published_at_once_and_empty_lists_at_the_rate(files):
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


def test_otherwise_it_publishes_at_the_rate_alone_what_collides_just_then(files):
    bumper = f"{BUMPER}, update_rate: 10, publish_all_collisions: false"
    robot = throw(files.robot(bumper, layers=wall(files)), 1.0)

    messages = robot.record("/collisions", 2.0)

    stamps = [message.header.stamp.to_nsec() for message in messages]
    assert stamps == [5_000_000 + 100_000_000 * i for i in range(20)]
    assert [len(message.collisions) for message in messages] == [0] * 8 + [1] * 12


@pytest.mark.parametrize(("publish_all", "is_told"), [("true", True), ("false", False)])
def test_a_collision_between_two_updates_is_told_of_only_with_all(files, publish_all, is_told):
    ball = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: 1}}"
    bumper = f"{BUMPER}, update_rate: 10, publish_all_collisions: {publish_all}"
    robot = files.robot(bumper, footprint=ball, layers=wall(files), pose="[0.65, 0, 0]")

    # At 3 m/s it is at the wall half way between two updates.
    assert bool(record(throw(robot, 3.0), 0.5)) == is_told
    assert robot.model().base.physics_body.velocity[0] == pytest.approx(-3.0, rel=1e-3)


def test_a_rate_that_is_no_multiple_of_the_step_is_kept_on_average(files):
    robot = files.robot(f"{BUMPER}, update_rate: 60")

    assert len(robot.record("/collisions", 5.0)) == 300


def test_the_stamp_is_the_time_after_the_step_as_clock_tells_it(files):
    robot = files.robot(BUMPER).run(0.1)

    message = robot.last("/collisions")

    assert message.header.stamp.to_nsec() == robot.timekeeper.nanoseconds == 100_000_000


# Topics and frames


def test_topic_and_frame_are_the_documented_ones(files):
    robot = files.robot(BUMPER, namespace="robot1").run()

    assert robot.transport.topics == {"/robot1/collisions"}
    assert robot.last("/robot1/collisions").header.frame_id == "map"


@pytest.mark.parametrize(("topic", "resolved"), [("bumps", "/robot1/bumps"), ("/bumps", "/bumps")])
def test_topic_and_frame_can_be_named(files, topic, resolved):
    bumper = f"{BUMPER}, topic: {topic}, world_frame_id: world"
    robot = files.robot(bumper, namespace="robot1").run()

    assert robot.transport.topics == {resolved}
    assert robot.last(resolved).header.frame_id == "world"


def test_nothing_is_published_that_nobody_listens_to(files, deaf_transport):
    robot = files.robot(BUMPER, layers=wall(files), transport=deaf_transport)

    throw(robot, 1.0).run(1.5)

    assert deaf_transport.published == []


def test_who_begins_to_listen_in_the_midst_of_a_collision_hears_of_it(files, deaf_transport):
    robot = throw(files.robot(BUMPER, layers=wall(files), transport=deaf_transport), 1.0).run(1.5)

    deaf_transport.publishers[0].has_subscribers = True
    press(robot, (2.0, 0.0), 0.005)

    [collision] = now(robot)
    assert collision.magnitude_forces == [pytest.approx(2.0, rel=1e-3)]


@pytest.mark.parametrize(
    "key", ["world_frame_id", "topic", "update_rate", "publish_all_collisions", "exclude"]
)
def test_a_key_without_its_last_letter_is_refused_with_a_suggestion(files, key):
    message = f'plugins[0] "bumper": unknown key "{key[:-1]}" (did you mean "{key}"?)'

    assert files.refusal(f"{BUMPER}, {key[:-1]}: 1") == f"robot.model.yaml:5: {message}"


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        pytest.param(
            "update_rate: 0",
            "plugins[0].update_rate: expected a number above 0, found 0",
            id="rate of zero",
        ),
        pytest.param(
            "publish_all_collisions: sometimes",
            'plugins[0].publish_all_collisions: expected true or false, found "sometimes"',
            id="no flag",
        ),
        pytest.param(
            "exclude: [bas]",
            'plugins[0].exclude: the model has no body "bas" (did you mean "base"?); it has: base',
            id="unknown body",
        ),
        pytest.param(
            "exclude: {base: true}",
            "plugins[0].exclude: expected a string, found a map",
            id="no list",
        ),
    ],
)
def test_a_wrong_configuration_is_refused_at_its_line(files, keys, message):
    assert files.refusal(f"{BUMPER}, {keys}") == f"robot.model.yaml:5: {message}"

"""The documentation's pages of sensors and such: examples run, defaults are as stated.

Those of drives are in test_drives.py.
"""

import pytest

STEPS_PER_SECOND = 200

EXAMPLES = {
    "bumper": (("base", "left_wheel", "right_wheel"), 2, {"/collisions"}),
    "bool_sensor": (("base", "detector"), 1, {"/detector_out"}),
    "laser": (("base_link",), 2, {"/scan"}),
    "model_tf_publisher": (("base_link", "castor_wheel"), 3, set()),
    "tween": (("some_body",), 1, set()),
    "gps": (("base",), 1, {"/gps/fix"}),
}
"""By page: the bodies that the example needs, how many plugins it has, and what they publish."""


@pytest.mark.parametrize(
    ("page", "bodies", "count", "topics"), [(page, *rest) for page, rest in EXAMPLES.items()]
)
def test_an_example_runs(documented, page, bodies, count, topics):
    robot = documented.robot(documented.page(page), documented.discs(*bodies))

    robot.run(0.1)

    assert robot.world.plugin_count == count
    assert robot.transport.topics == topics
    assert all(robot.transport.last(topic) is not None for topic in topics)


# Bumper


def test_the_bumpers_of_the_example_have_frames_and_rates_of_their_own(documented):
    bodies = documented.discs("base", "left_wheel", "right_wheel")
    robot = documented.robot(documented.page("bumper"), bodies)

    messages = robot.record("/collisions", 1.0)

    # Both publish to the same topic, whose last message at a step is that of the second.
    frames = [message.header.frame_id for message in messages]
    assert (frames.count("world"), frames.count("map")) == (STEPS_PER_SECOND - 60, 60)


def test_the_bumpers_of_the_example_ignore_the_bodies_that_they_are_told_to(documented):
    names = ("base", "left_wheel", "right_wheel")
    robot = documented.robot(documented.page("bumper"), documented.discs(*names))

    messages = robot.throw(1.0, *names).record("/collisions", 1.0)

    reported = {
        (message.header.frame_id, collision.body_A)
        for message in messages
        for collision in message.collisions
    }
    assert reported == {("map", "base"), *(("world", name) for name in names)}


@pytest.mark.parametrize(
    ("key", "colliding"), [("", STEPS_PER_SECOND), (", publish_all_collisions: false", 2)]
)
def test_a_bumper_publishes_all_collisions_by_default(documented, key, colliding):
    robot = documented.robot(f"type: Bumper, name: bumper, update_rate: 2{key}")

    # 0.8 m to the wall, where it stays.
    free = robot.throw(1.0, "base").record("/collisions", 0.5)
    robot.run(0.5)
    touching = robot.record("/collisions", 1.0)[-colliding:]

    assert [message.collisions for message in free] == [[]]
    assert [len(message.collisions) for message in touching] == [1] * colliding


# Bool Sensor


def test_the_bool_sensor_of_the_example_is_in_the_models_namespace(documented):
    bodies = documented.discs("base", "detector")
    robot = documented.robot(documented.page("bool_sensor"), bodies, namespace="foo")

    messages = robot.throw(1.0, "detector").record("/foo/detector_out", 1.0)

    # 0.8 m to the wall at 1 m/s, and 10 Hz.
    assert [message.data for message in messages] == [False] * 8 + [True] * 2


# Model TF Publisher


@pytest.mark.parametrize("plugins", ["example", "type: ModelTfPublisher, name: least"])
def test_the_transforms_by_default_and_of_the_example_are_from_the_first_body(documented, plugins):
    if plugins == "example":
        plugins = documented.page("model_tf_publisher")
    robot = documented.robot(plugins, documented.discs("base_link", "castor_wheel"))

    for step in range(20):
        robot.run(0.005)
        stamp = robot.transport.transforms["castor_wheel"].nanoseconds
        assert stamp == step * 5_000_000  # when the step begins

    assert robot.frames == {("base_link", "castor_wheel")}


# Tween


def test_the_tween_of_the_example_goes_to_and_fro_in_twenty_seconds(documented):
    bodies = documented.discs("some_body")
    robot = documented.robot(documented.page("tween"), bodies, pose="[2, 0, 0]")

    quarter = robot.run(2.5).pose("some_body")
    end = robot.run(7.5).pose("some_body")
    start = robot.run(10.0).pose("some_body")

    eased = 4 * 0.25**3  # cubicInOut, in its first half
    assert quarter == pytest.approx((2 + 2 * eased, 3 * eased, 1.1 * eased), abs=1e-5)
    assert end == pytest.approx((4.0, 3.0, 1.1), abs=1e-5)
    assert start == pytest.approx((2.0, 0.0, 0.0), abs=1e-5)


# GPS


def test_the_gps_of_the_example_is_where_the_world_begins(documented):
    robot = documented.robot(documented.page("gps"))

    fixes = robot.record("/gps/fix", 1.0)

    assert len(fixes) == 10
    for fix in fixes:
        assert (fix.latitude, fix.longitude) == pytest.approx((0.0, 0.0), abs=1e-12)
        assert fix.header.frame_id == "my_frame_name"
    assert robot.frames == {("base", "my_frame_name")}

"""The documentation's pages about other plugins: the examples run, the defaults are as stated.

The pages about drives are tested in test_drives.py.
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
"""For each page: the bodies that its example needs, the number of its plugins, and their topics."""


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


def test_the_example_bumpers_have_their_own_frames_and_rates(documented):
    bodies = documented.discs("base", "left_wheel", "right_wheel")
    robot = documented.robot(documented.page("bumper"), bodies)

    messages = robot.record("/collisions", 1.0)

    # Both publish to the same topic; the last message of a step is that of the second.
    frames = [message.header.frame_id for message in messages]
    assert (frames.count("world"), frames.count("map")) == (STEPS_PER_SECOND - 60, 60)


def test_the_bumpers_of_the_example_ignore_the_excluded_bodies(documented):
    names = ("base", "left_wheel", "right_wheel")
    robot = documented.robot(documented.page("bumper"), documented.discs(*names))

    messages = robot.throw(1.0, *names).record("/collisions", 1.0)

    reported = {
        (message.header.frame_id, collision.body_A)
        for message in messages
        for collision in message.collisions
    }
    assert reported == {("map", "base"), *(("world", name) for name in names)}


# Bool Sensor


def test_the_example_bool_sensor_is_in_the_models_namespace(documented):
    bodies = documented.discs("base", "detector")
    robot = documented.robot(documented.page("bool_sensor"), bodies, namespace="foo")

    messages = robot.throw(1.0, "detector").record("/foo/detector_out", 1.0)

    # 0.8 m to the wall at 1 m/s, and 10 Hz.
    assert [message.data for message in messages] == [False] * 8 + [True] * 2


# Model TF Publisher


@pytest.mark.parametrize("plugins", ["example", "type: ModelTfPublisher, name: least"])
def test_transforms_are_from_the_first_body(documented, plugins):
    if plugins == "example":
        plugins = documented.page("model_tf_publisher")
    robot = documented.robot(plugins, documented.discs("base_link", "castor_wheel"))

    for step in range(20):
        robot.run(0.005)
        stamp = robot.transport.transforms["castor_wheel"].nanoseconds
        assert stamp == step * 5_000_000  # when the step begins

    assert robot.frames == {("base_link", "castor_wheel")}


# Tween


# GPS


def test_the_gps_of_the_example_is_at_the_origin_of_the_world(documented):
    robot = documented.robot(documented.page("gps"))

    fixes = robot.record("/gps/fix", 1.0)

    assert len(fixes) == 10
    for fix in fixes:
        assert (fix.latitude, fix.longitude) == pytest.approx((0.0, 0.0), abs=1e-12)
        assert fix.header.frame_id == "my_frame_name"
    assert robot.frames == {("base", "my_frame_name")}

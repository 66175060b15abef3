"""Names that ROS cannot have, and topics that have an owner or a type already."""

import pytest

from flatland_server.config.ros_names import MAX_LENGTH
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose

LONG = "a" * 70_000
NO_TOPICS = ["''", "a b", "a//b", "a/", "//a", "/", "a-b", "äh", "a\\tb", LONG, "a" * 256]
NO_FRAMES = ["''", " a", "a ", "a /b", "a\\tb", "a//b", "a/", "//a", "/", LONG, "a" * 256]
NO_NAMES = ["''", "a\\tb", "a\\nb", LONG, "a" * 256]

MODEL = """\
bodies:
- name: {body}
  footprints: [{{type: circle, radius: 0.1, density: 1}}]
plugins:
- type: {type}
  name: {name}
  body: {body}
  {key}: {value}
"""
KEYS = {
    "DiffDrive": ("twist_sub", "odom_pub", "ground_truth_pub", "twist_pub"),
    "Gps": ("topic",),
    "Bumper": ("topic",),
    "Imu": ("imu_pub", "ground_truth_pub"),
}
FRAME_KEYS = {
    "DiffDrive": ("odom_frame_id", "ground_truth_frame_id"),
    "Gps": ("frame",),
    "Imu": ("imu_frame_id",),
    "ModelTfPublisher": ("world_frame_id",),
}


def quoted(name: str) -> str:
    """The YAML of a name."""
    return name if name == "''" or name == LONG else f'"{name}"'


@pytest.fixture
def refusal(files):
    """The message with which a model of one plugin is refused, without the folder's name."""

    def refusal(kind="Gps", key="topic", value="t", body="base", name="plugin") -> str:
        text = MODEL.format(type=kind, key=key, value=value, body=body, name=name)
        if kind == "ModelTfPublisher":
            text = text.replace(f"  body: {body}\n", "  publish_tf_world: true\n")
        with pytest.raises(FlatlandError) as caught:
            files.spawn(text)
        return files.without_folder(str(caught.value))

    return refusal


@pytest.mark.parametrize(
    ("kind", "keys", "name", "expected"),
    [
        *((*item, name, "a topic of letters, ") for item in KEYS.items() for name in NO_TOPICS),
        *((*item, name, "a name without emp") for item in FRAME_KEYS.items() for name in NO_FRAMES),
    ],
)
def test_a_name_that_ros_or_tf_cannot_have_is_refused(refusal, kind, keys, name, expected):
    for key in keys:
        message = refusal(kind, key, quoted(name))

        assert message.startswith(f"spawned.model.yaml:8: plugins[0].{key}: expected {expected}")
        assert len(message) < 300


@pytest.mark.parametrize("name", NO_NAMES)
def test_names_of_bodies_and_plugins_are_a_line_of_text(refusal, name):
    expected = f"expected a name of at most {MAX_LENGTH} characters, on one line"

    assert f"spawned.model.yaml:2: bodies[0].name: {expected}" in refusal(body=quoted(name))
    assert f"spawned.model.yaml:6: plugins[0].name: {expected}" in refusal(name=quoted(name))


@pytest.mark.parametrize("name", NO_TOPICS)
@pytest.mark.parametrize(
    ("old", "place"),
    [
        ("name: robot", "world.yaml:10: models[0].name: "),
        ("name: floor", "world.yaml:8: layers[2].name: "),
        ("namespace: r1", "world.yaml:11: models[0].namespace: "),
    ],
)
def test_names_that_are_no_part_of_a_topic_are_refused(good_files, name, old, place):
    key = old.partition(":")[0]
    good_files.edit("world.yaml", old, f"{key}: {quoted(name)}")
    if key == "namespace" and name in ("''", "a/", "/", "//a"):
        good_files.load().close()  # it may be empty, and slashes at its ends do not count
        return

    message = good_files.refusal()

    assert message.startswith(place)
    assert len(message) < 300


@pytest.mark.parametrize("name", NO_TOPICS)
def test_a_spawned_model_has_a_name_that_ros_can_have(good_files, name):
    world = good_files.load()
    path = good_files.folder / "robot.model.yaml"
    name = "" if name == "''" else name.replace("\\t", "\t")

    with pytest.raises(FlatlandError, match="expected a name"):
        world.spawn_model(path, name, "", Pose())


@pytest.mark.parametrize(
    ("body", "name", "topic"),
    [("a" * MAX_LENGTH,) * 3, ("base-link.2", "gps-1", "a/1b")],
    ids=["the longest", "of robots"],
)
def test_names_that_are_accepted(files, body, name, topic):
    world = files.spawn(MODEL.format(body=body, type="Gps", name=name, key="topic", value=topic))

    assert world.transport.topics == {f"/{topic}"}


@pytest.mark.parametrize("name", ["My Plugin", "a//b", "(1)", " - ", "ä"])
def test_a_name_that_nothing_of_ros_is_made_of_is_any_text(files, name):
    text = MODEL.format(
        body=quoted(name), type="Tween", name=quoted(name), key="delta", value="[1, 0, 0]"
    )
    world = files.spawn(f"{text}  duration: 2\n")

    (model,) = world.models.values()
    assert model.get_body(name).name == name


def test_a_frame_made_of_names_may_have_spaces_and_no_empty_part(files):
    laser = "  range: 10\n  angle: {min: -1, max: 1, increment: 0.5}\n"
    spaced = {"body": "my base", "type": "Laser", "key": "topic", "value": "scan"}

    files.spawn(MODEL.format(name="My Laser", **spaced) + laser)
    with pytest.raises(FlatlandError, match=r"plugins\[0\].name: expected .* \(it names a frame\)"):
        files.spawn(MODEL.format(name="a//b", **spaced) + laser)


# Topics of two types


TWO = """\
bodies:
- {{name: base, footprints: [{{type: circle, radius: 0.1, density: 1}}]}}
plugins:
- {{type: Gps, name: gps, body: base, topic: {}}}
- {{type: Bumper, name: bumper, topic: {}}}
"""


@pytest.mark.parametrize(("first", "second"), [("x", "x"), ("/x", "x"), ("a/b", "/a/b")])
def test_a_topic_with_two_types_is_refused_naming_both_plugins(files, first, second):
    with pytest.raises(FlatlandError) as caught:
        files.spawn(TWO.format(first, second))

    name = f"/{second.lstrip('/')}"
    assert files.without_folder(str(caught.value)) == (
        f'spawned.model.yaml:5: plugins[1].topic: the topic "{name}" has the type '
        "sensor_msgs/NavSatFix, of the plugin robot/gps, not flatland_msgs/Collisions"
    )


@pytest.mark.parametrize(
    "topic",
    [
        *("clock", "/clock", "/tf", "/rosout", "/diagnostics", "interactive_model_markers/update"),
        *(f"/flatland_server/{each}" for each in ("debug/topics", "debug/model/robot", "state")),
    ],
)
def test_a_topic_of_the_server_is_refused(refusal, topic):
    name = f"/{topic.lstrip('/')}"

    assert refusal(value=topic).startswith(
        f'spawned.model.yaml:8: plugins[0].topic: the topic "{name}" is the server\'s own'
    )


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        (
            "enable_twist_pub",
            "true\n  odom_pub: x\n  twist_pub: x",
            'the topic "/x" has the type nav_msgs/Odometry, of the plugin robot/plugin',
        ),
        ("twist_sub", "odom\n  odom_pub: odom", 'the topic "/odom" has the type'),
        (
            "twist_sub",
            "/clock",
            'the topic "/clock" has the type rosgraph_msgs/Clock, not geometry_msgs/Twist',
        ),
    ],
    ids=["two publishers", "a subscriber", "a topic of ROS"],
)
def test_a_plugin_cannot_have_two_types_on_one_topic_itself(refusal, key, value, problem):
    assert problem in refusal("DiffDrive", key, value)


def test_the_topics_of_a_deleted_model_may_have_another_type(files):
    world = files.spawn(TWO.format("x", "y"))
    world.spawn_model(files.write("same.yaml", TWO.format("x", "y")), "same", "", Pose())
    world.delete_model("same")
    world.delete_model("robot")
    path = files.write("other.yaml", TWO.format("y", "x"))

    world.spawn_model(path, "other", "", Pose())

    assert world.transport.topics == {"/x", "/y"}

"""Frames outside of a model: as they are written, or within the namespace; several robots."""

from collections import defaultdict
from pathlib import Path
from typing import Dict, List, Set, Tuple

import pytest
from logged import warnings

from flatland_server import Pose
from flatland_server.testing import Harness
from flatland_server.testing.observation import ObservingTransport

OFFICE = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds" / "office"
DRIVE = "type: DiffDrive, name: drive, body: base"
TF = "type: ModelTfPublisher, name: tf, publish_tf_world: true"
BUMPER = "type: Bumper, name: bumper"


def frame_of(robot: Harness, topic: str) -> str:
    return str(robot.last(topic).header.frame_id)


@pytest.mark.parametrize(
    ("written", "namespace", "frame"),
    [
        ("earth", "", "earth"),
        ("/earth", "r1", "earth"),
        ("~earth", "", "earth"),
        ("~earth", "r1", "r1_earth"),
        ("~/earth", "r1", "r1_earth"),
        ('$eval "~" .. "earth"', "r1", "r1_earth"),
    ],
)
@pytest.mark.parametrize(
    ("plugin", "key", "topic"),
    [
        (DRIVE, "odom_frame_id", "odometry/filtered"),
        (DRIVE, "ground_truth_frame_id", "odometry/ground_truth"),
        (BUMPER, "world_frame_id", "collisions"),
        (TF, "world_frame_id", ""),
    ],
)
def test_a_frame_is_as_it_is_written_or_within_the_namespace(
    files, plugin, key, topic, written, namespace, frame
):
    robot = files.robot(f"{plugin}, {key}: {written}", namespace=namespace).run()

    if key == "odom_frame_id" or not topic:
        [transform] = robot.transport.transforms.values()
        assert transform.parent == frame
    if topic:
        assert frame_of(robot, f"/{namespace}/{topic}" if namespace else topic) == frame


@pytest.mark.parametrize(
    ("keys", "frame"),
    [
        ("odom_frame_id: odom", "r1_odom"),
        ("odom_frame_id: ~odom", "r1_odom"),
        ("odom_frame_id: map", "map"),  # that of the ground truth
    ],
)
def test_a_namespace_with_a_tilde_has_a_frame_of_odometry(files, keys, frame):
    robot = files.robot(f"{DRIVE}, {keys}", namespace="~r1").run()

    [(child, transform)] = robot.transport.transforms.items()
    assert (transform.parent, child) == (frame, "r1_base")
    assert frame_of(robot, "/r1/odometry/filtered") == frame


def test_a_tilde_alone_is_the_default_frame_unless_it_is_quoted(files):
    for key in ("~", ""):  # YAML's null
        robot = files.robot(f"{DRIVE}, odom_frame_id: {key}", namespace="r1").run()
        assert frame_of(robot, "/r1/odometry/filtered") == "odom"
    refusal = files.robot_refusal(f"{DRIVE}, odom_frame_id: '~'")
    expected = 'expected a frame, such as "~odom", found "~"'
    assert refusal == f"robot.model.yaml:5: plugins[0].odom_frame_id: {expected}"


def test_a_world_has_no_namespace(town):
    people = town("pose: [1, 1, 0]", keys="world_frame_id: ~earth").run()

    assert frame_of(people, "/people/poses") == "earth"


# Several robots


def tree_of(frame: str, parents: Dict[str, str]) -> str:
    """The frame at the root of the tree that a frame belongs to."""
    return tree_of(parents[frame], parents) if frame in parents else frame


def test_four_robots_from_one_file_have_four_trees_of_frames(files, caplog):
    transport, model = ObservingTransport(), OFFICE / "turtlebot.model.yaml"
    entry = f"model: {model}, namespace: r{{0}}, pose: [0, {{1}}, {{0}}]"
    models = {f"robot{i}": entry.format(i, 2 * i) for i in range(4)}
    robots = files.load_models(models, transport=transport)
    transport.timekeeper = robots.timekeeper
    for i in range(4):
        robots.drive(0.1 * (i + 1), 0.2, topic=f"/r{i}/cmd_vel")

    robots.run(1.0)

    parents: Dict[str, Set[str]] = defaultdict(set)
    sent: List[Tuple[str, int]] = []
    for _, _, transform in transport.sent_transforms:
        parents[transform.child].add(transform.parent)
        sent.append((transform.child, transform.nanoseconds))
    assert {child: len(each) for child, each in parents.items()} == dict.fromkeys(parents, 1)
    assert len(sent) == len(set(sent))  # tf2 warns of a transform that it has already
    trees: Dict[str, Set[str]] = defaultdict(set)
    for child in parents:
        trees[tree_of(child, {name: min(each) for name, each in parents.items()})].add(child)
    frames = ("base_link", "laser", "left_wheel", "right_wheel")
    assert trees == {f"r{i}_odom": {f"r{i}_{name}" for name in frames} for i in range(4)}
    assert warnings(caplog) == []
    for i in range(4):
        twist = robots.last(f"/r{i}/odometry/ground_truth").twist.twist
        assert twist.linear.x == pytest.approx(0.1 * (i + 1), abs=1e-3)


def robots_in_one_frame(files, count: int, *plugins: str) -> Harness:
    model = files.model("robot", *plugins)
    return files.load_models(
        {f"robot{i}": f"model: {model}, namespace: r{i}, pose: [0, {i}, 0]" for i in range(count)}
    )


@pytest.mark.parametrize("count", [2, 4])
def test_robots_that_share_an_odometry_frame_are_warned_of_once(files, caplog, count):
    robots_in_one_frame(files, count, DRIVE).run(0.1)

    [message] = warnings(caplog)
    for part in ('"odom"', "robot0/drive", "robot1/drive", "odom_frame_id: ~odom", "namespace"):
        assert part in message


@pytest.mark.parametrize(
    ("count", "plugins"),
    [
        (1, (DRIVE,)),
        (2, (f"{DRIVE}, odom_frame_id: ~odom",)),
        (2, (f"{DRIVE}, enable_odom_tf_pub: false",)),
        (2, (f"{DRIVE}, odom_frame_id: map",)),  # in the world's frame, as the ground truth
        (2, (f"{DRIVE}, odom_frame_id: ~odom", "type: ModelTfPublisher, name: tf")),
        (2, (TF,)),
    ],
)
def test_own_frames_and_the_world_frame_cause_no_warning(files, caplog, count, plugins):
    robots_in_one_frame(files, count, *plugins).run(0.1)

    assert warnings(caplog) == []


def test_a_robot_that_replaces_another_is_not_warned_of(files, caplog):
    robots = robots_in_one_frame(files, 1, DRIVE).run()
    pose = robots.model("robot0").pose

    robots.world.delete_model("robot0")
    robots.world.spawn_model(files.folder / "robot.model.yaml", "other", "other", pose)
    assert warnings(caplog) == []
    robots.world.spawn_model(files.folder / "robot.model.yaml", "third", "third", Pose(5, 5, 0))

    [message] = warnings(caplog)
    assert "other/drive and third/drive" in message


def test_two_drives_of_one_model_may_share_an_odometry_frame(files, caplog):
    bodies = "[{name: base, footprints: []}, {name: trailer, footprints: []}]"
    second = "{type: OmniDrive, name: second, body: trailer, odom_pub: o, ground_truth_pub: g}"
    files.write("two.yaml", f"bodies: {bodies}\nplugins: [{{{DRIVE}}}, {second}]")

    files.load_models({"robot": "model: two.yaml"}).run()

    assert warnings(caplog) == []

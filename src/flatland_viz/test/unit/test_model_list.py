"""The models as the server describes them, and names for new ones."""

import pytest
from flatland_msgs.msg import BodyInfo, ModelInfo, ModelList, PluginInfo, TopicInfo

from flatland_viz.model_list import (
    free_name,
    models_of,
    namespace_of_copy,
    sorted_topics,
    topic_owners,
)

ODOMETRY = TopicInfo("/r2/odometry/filtered", "nav_msgs/Odometry", True)
COMMAND = TopicInfo("/r2/cmd_vel", "geometry_msgs/Twist", False)
SCAN = TopicInfo("/r2/scan", "sensor_msgs/LaserScan", True)
ROBOT = ModelInfo(
    name="r2",
    ns="r2",
    yaml_path="/models/robot.model.yaml",
    bodies=[
        BodyInfo(name="base", min_x=-0.5, max_x=0.75, min_y=-0.3, max_y=0.3),
        BodyInfo(name="mast", min_x=-0.1, max_x=0.1, min_y=-1.0, max_y=0.0),
    ],
    plugins=[
        PluginInfo("drive", "DiffDrive", False, [COMMAND, ODOMETRY]),
        PluginInfo("laser", "Laser", True, [SCAN]),
    ],
)


def test_a_robot_is_read():
    robot = models_of(ModelList([ROBOT]))["r2"]

    assert robot.plugins == ("drive (DiffDrive)", "laser (Laser)")
    assert robot.failed == ("laser",)
    assert robot.command_topic == "/r2/cmd_vel"
    assert robot.size == 1.25
    assert not robot.steers
    published = ["/r2/odometry/filtered", "/r2/scan"]
    assert [topic.name for topic in sorted_topics(robot.topics)] == [*published, "/r2/cmd_vel"]


def test_models_are_in_natural_order_and_own_their_scans():
    others = [ModelInfo(name=name) for name in ("r10", "crate", "R9")]
    models = models_of(ModelList([*others, ROBOT]))

    assert list(models) == ["R9", "crate", "r2", "r10"]
    assert topic_owners(models) == {"/r2/scan": "r2", "/r2": "r2"}
    assert (models["crate"].command_topic, models["crate"].size) == ("", 0.0)
    drive = PluginInfo("drive", "TricycleDrive", False, [COMMAND])
    assert models_of(ModelList([ModelInfo(name="t", plugins=[drive])]))["t"].steers


@pytest.mark.parametrize(
    ("wanted", "taken", "free"),
    [
        ("r2", ["r1"], "r2"),
        ("r2", ["r2", "r3"], "r4"),
        ("box", ["box"], "box_2"),
        ("box_9", ["box_9"], "box_10"),
    ],
)
def test_a_free_name_counts_on(wanted, taken, free):
    assert free_name(wanted, taken) == free


@pytest.mark.parametrize(
    ("namespace", "plugins", "name", "copied"),
    [
        ("r2", ("drive (DiffDrive)",), "robot_2", "r3"),
        ("", ("drive (DiffDrive)",), "robot_2", "robot_2"),
        ("", ("drive (DiffDrive)",), "2. robot-2", "m2__robot_2"),
        ("", (), "box_2", ""),  # has no topics
    ],
)
def test_a_copy_has_a_namespace_of_its_own(namespace, plugins, name, copied):
    original = models_of(ModelList([ROBOT]))["r2"]._replace(namespace=namespace, plugins=plugins)
    others = [original._replace(namespace="r2")]
    assert namespace_of_copy(original, name, [original, *others]) == copied

"""The parameters of the nodes, and the walls of worlds."""

from pathlib import Path

import numpy as np
import pytest

from flatland_navigation import parameters
from flatland_navigation.navigator import NavigatorConfig
from flatland_server import FlatlandError, Pose, World

OFFICE = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds" / "office"
WORLD = str(OFFICE / "world.yaml")


@pytest.fixture
def params(monkeypatch):
    """The parameters on the server."""
    values = {"/flatland_server/world_path": WORLD}
    monkeypatch.setattr(
        parameters.rospy, "get_param", lambda name, default=None: values.get(name, default)
    )
    return values


def test_defaults(params):
    read = parameters.NodeParameters.read()

    assert read.world_path == Path(WORLD)
    assert read.pose_source == "ground_truth"
    assert read.navigator == NavigatorConfig()
    assert read.read_grid().clearance == pytest.approx(0.25)


def test_the_nodes_world_comes_before_the_servers(params):
    params["~world_path"] = "/other.yaml"

    assert parameters.NodeParameters.read().world_path == Path("/other.yaml")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("~max_speed", 0, "~max_speed: expected a number above 0, found 0"),
        ("~lookahead", "far", "~lookahead: expected a number above 0, found far"),
        ("~clearance", float("inf"), "~clearance: expected a number above 0, found inf"),
        ("~robot_radius", True, "~robot_radius: expected a number above 0, found True"),
        ("~pose_source", "gps", "~pose_source: expected ground_truth or tf, found gps"),
        ("~layers", "map", "~layers: expected a list of names, found map"),
        ("/flatland_server/world_path", "", "no world: start the server first"),
    ],
)
def test_wrong_parameters_are_refused(params, name, value, message):
    params[name] = value

    with pytest.raises(FlatlandError, match=message):
        parameters.NodeParameters.read()


def test_walls_are_those_of_the_chosen_layers():
    expected = World.from_file(Path(WORLD)).layers[0].segments

    assert np.array_equal(parameters.read_walls(Path(WORLD)), expected)
    assert np.array_equal(parameters.read_walls(Path(WORLD), ("map",)), expected)
    with pytest.raises(FlatlandError, match=r"has no layer \"ceiling\"; it has \['map'\]"):
        parameters.read_walls(Path(WORLD), ("ceiling",))


@pytest.mark.parametrize("value", [[[1, 2, 0.5], [3, 4, 0]], "[[1, 2, 0.5], [3, 4, 0]]"])
def test_goals(params, value):
    params["~goals"] = value

    assert parameters.read_goals() == [Pose(1, 2, 0.5), Pose(3, 4, 0)]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (None, r"expected \[\[x, y, yaw\], ...\], found None"),
        ([], r"found \[\]"),
        ("[[1, 2", r"found \[\[1, 2"),
        ([[1, 2]], r"~goals\[0\]: expected \[x, y, yaw\], found \[1, 2\]"),
        ([[1, 2, 3], [1, 2, "nan"]], r"~goals\[1\]: expected"),
        ([[1, 2, 3], 4], r"~goals\[1\]: expected"),
    ],
)
def test_wrong_goals_are_refused(params, value, message):
    params["~goals"] = value

    with pytest.raises(FlatlandError, match=message):
        parameters.read_goals()

"""The documentation's examples of worlds, layers and models run; their defaults are as stated."""

import math

import numpy as np
import pytest
import yaml

from flatland_server.simulation.world_config import WorldConfig

# Worlds and layers


def test_the_world_example_runs(documented):
    simulation = documented.load("world.yaml").run(0.1)

    world = simulation.world
    assert [layer.config.names for layer in world.layers] == [
        ("layer_1",),
        ("layer_2", "layer_3", "layer_4"),
    ]
    assert world.registry.names == ["layer_1", "layer_2", "layer_3", "layer_4"]
    assert world.layers[1].config.bits == 0b1110
    assert {name: model.namespace for name, model in world.models.items()} == {
        "turtlebot1": "",
        "turtlebot12": "turtlebot2",
        "person": "",
    }
    assert simulation.transport.subscribed == {"/cmd_vel", "/turtlebot2/cmd_vel"}


def points_of(documented, map):
    """The ends of the walls of a world with this map and nothing else."""
    text = f"{{properties: {{}}, layers: [{{name: map, map: {map}}}]}}"
    documented.files.write("least.yaml", text)
    return documented.load("least.yaml").world.layers[0].segments.reshape(-1, 2)


def test_the_examples_of_maps_load(documented):
    points = points_of(documented, "layer_1.yaml")  # 40 pixels of 5 cm, from the origin
    assert points.min(axis=0) == pytest.approx((-16.6, -6.65))
    assert points.max(axis=0) == pytest.approx((-14.6, -4.65))

    cos, sin = math.cos(1.23), math.sin(1.23)
    points = [(0, 0), (1, 1), (2, 3), (-1, 2)]
    placed = [(-1.2 + 0.1 * (cos * x - sin * y), -5 + 0.1 * (sin * x + cos * y)) for x, y in points]
    assert points_of(documented, "layer_2.yaml") == pytest.approx(np.array(placed))


def test_the_worlds_defaults(documented):
    """Defaults of layers, bodies, footprints and joints are in test_random_files.py."""
    documented.files.write(
        "world.yaml",
        "{properties: {}, layers: [], models: [{name: turtlebot, model: turtlebot.model.yaml}]}",
    )

    config = WorldConfig.from_file(documented.folder / "world.yaml")

    assert (config.velocity_iterations, config.position_iterations) == (10, 10)
    assert (config.models[0].namespace, config.models[0].pose) == ("", (0.0, 0.0, 0.0))
    assert config.plugins == ()


# Models


def test_the_model_example_runs(documented):
    simulation = documented.spawn("model.yaml")

    scans = simulation.record("/scan", 1.0)

    robot = simulation.world.get_model("robot")
    assert len(scans) == 10
    assert list(robot.bodies) == ["base_link", "rear_wheel", "left_wheel", "right_wheel"]
    assert [(joint.name, joint.config.type) for joint in robot.joints] == [
        ("rear_wheel_revolute", "revolute"),
        ("left_wheel_weld", "weld"),
        ("right_wheel_weld", "weld"),
    ]
    assert robot.joints[0].config.limits == (0.0, 0.0)
    assert robot.joints[0].config.bodies == ("rear_wheel", "base_link")
    assert robot.joints[0].config.anchors == ((0.0, 0.0), (-0.83, -0.29))


@pytest.mark.parametrize("section", ["bodies", "joints", "plugins"])
def test_entries_are_enabled_by_default(documented, section):
    given = [entry["name"] for entry in yaml.safe_load(documented.text("model.yaml"))[section]]

    model = documented.model("model.yaml")

    assert [entry.name for entry in getattr(model, section)] == given

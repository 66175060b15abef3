"""The documentation's examples of worlds, layers and models run; their defaults are as stated."""

import math
import textwrap

import numpy as np
import pytest
import yaml

from flatland_server.models.collision_filter_registry import ALL_LAYERS
from flatland_server.models.footprint import Circle, Polygon
from flatland_server.simulation.world_config import WorldConfig

LEAST_FOOTPRINTS = """
  - {type: circle, radius: 1, density: 1}
  - {type: polygon, points: [[0, 0], [1, 0], [0, 1]], density: 1}
"""
LEAST_ENDS = "[{name: base, anchor: [0, 0]}, {name: wheel, anchor: [0, 0]}]"


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


def test_the_map_example_loads(documented):
    documented.files.write(
        "least.yaml", "{properties: {}, layers: [{name: map, map: layer_1.yaml}]}"
    )

    segments = documented.load("least.yaml").world.layers[0].segments

    # 40 pixels of 5 cm, from the origin.
    assert segments.reshape(-1, 2).min(axis=0) == pytest.approx((-16.6, -6.65))
    assert segments.reshape(-1, 2).max(axis=0) == pytest.approx((-14.6, -4.65))


def test_the_line_segments_example_loads(documented):
    documented.files.write(
        "least.yaml", "{properties: {}, layers: [{name: map, map: layer_2.yaml}]}"
    )

    segments = documented.load("least.yaml").world.layers[0].segments

    cos, sin = math.cos(1.23), math.sin(1.23)
    points = [(0, 0), (1, 1), (2, 3), (-1, 2)]
    placed = [(-1.2 + 0.1 * (cos * x - sin * y), -5 + 0.1 * (sin * x + cos * y)) for x, y in points]
    assert segments.reshape(-1, 2) == pytest.approx(np.array(placed))


def test_the_worlds_defaults(documented):
    documented.files.write(
        "world.yaml",
        """
        properties: {}
        layers: [{name: layer_1, map: layer_1.yaml}]
        models: [{name: turtlebot, model: turtlebot.model.yaml}]
        """,
    )

    config = WorldConfig.from_file(documented.folder / "world.yaml")

    assert (config.velocity_iterations, config.position_iterations) == (10, 10)
    assert config.layers[0].color == (1.0, 1.0, 1.0, 1.0)
    assert config.models[0].namespace == ""
    assert config.models[0].pose == (0.0, 0.0, 0.0)
    assert config.plugins == ()


def test_models_are_optional(documented):
    documented.files.write(
        "world.yaml", "{properties: {}, layers: [{name: map, map: layer_1.yaml}]}"
    )

    assert WorldConfig.from_file(documented.folder / "world.yaml").models == ()


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


def test_the_models_defaults(documented):
    documented.files.write(
        "least.yaml",
        f"""
bodies:
  - name: base
    footprints: {textwrap.indent(LEAST_FOOTPRINTS, "    ")}
  - name: wheel
    footprints: []
joints:
  - {{name: r, type: revolute, bodies: {LEAST_ENDS}}}
  - {{name: w, type: weld, bodies: {LEAST_ENDS}}}
""",
    )

    model = documented.model("least.yaml")

    body = model.bodies[0]
    assert body.pose == (0.0, 0.0, 0.0)
    assert body.type == "dynamic"
    assert body.color == (1.0, 1.0, 1.0, 0.5)
    assert (body.linear_damping, body.angular_damping) == (0.0, 0.0)
    circle, polygon = body.footprints
    assert circle.shape == Circle((0.0, 0.0), 1.0)
    assert polygon.shape == Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
    for footprint in body.footprints:
        assert footprint.layers == ("all",)
        assert footprint.layer_bits == ALL_LAYERS
        assert footprint.collision is True
        assert footprint.sensor is False
        assert (footprint.friction, footprint.restitution) == (0.0, 0.0)
    hinge, weld = model.joints
    for joint in model.joints:
        assert joint.collide_connected is False
    assert hinge.limits is None
    assert (weld.angle, weld.frequency, weld.damping) == (0.0, 0.0, 0.0)
    assert model.plugins == ()


def test_joints_and_plugins_are_optional(documented):
    model = documented.model("person.model.yaml")

    assert (model.joints, model.plugins) == ((), ())


@pytest.mark.parametrize("section", ["bodies", "joints", "plugins"])
def test_entries_are_enabled_by_default(documented, section):
    given = [entry["name"] for entry in yaml.safe_load(documented.text("model.yaml"))[section]]

    model = documented.model("model.yaml")

    assert [entry.name for entry in getattr(model, section)] == given

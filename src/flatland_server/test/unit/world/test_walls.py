"""Finding layers by their names, and adding walls to them."""

import math

import numpy as np
import pytest
from world.parts import BODIES, EMPTY, spawn

from flatland_server import _core
from flatland_server.exceptions import LayerError
from flatland_server.geometry import Pose

TWO_LAYERS = "properties: {}\nlayers: [{name: [ground, floor]}, {name: glass}]\n"
WALL = np.array([[2.0, -1.0, 2.0, 1.0]])
AHEAD = _core.BeamFan(0.0, 0.1, 1)


@pytest.mark.parametrize(("name", "index"), [("ground", 0), ("floor", 0), ("glass", 1)])
def test_a_layer_is_found_by_any_of_its_names(models, name, index):
    world = models.load(TWO_LAYERS)

    assert world.get_layer(name) is world.layers[index]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TWO_LAYERS, ' (did you mean "ground"?); there are: ground, floor, glass'),
        (EMPTY, "; there are: none"),
    ],
)
def test_the_error_for_an_unknown_layer_lists_all_layers(models, text, message):
    world = models.load(text)

    for ask in (world.get_layer, lambda name: world.add_walls(name, WALL)):
        with pytest.raises(LayerError) as caught:
            ask("gruond")
        assert str(caught.value) == f'no layer is named "gruond"{message}'


def test_added_walls_act_in_their_layer_only(models, simulate):
    world = models.load(TWO_LAYERS)
    models.write("glider.yaml", BODIES.replace("density: 1", "density: 1, layers: [glass]"))
    robot = spawn(models, world, "plain.yaml", "robot", pose=Pose(1.0, 0.5, 0.0))
    glider = spawn(models, world, "glider.yaml", "glider", pose=Pose(1.0, -0.5, 0.0))
    world.add_walls("floor", WALL)
    for model in (robot, glider):
        for body in model.physics_bodies:
            body.velocity = (1.0, 0.0, 0.0)
    ground, glass = world.registry.bits(["ground", "floor"]), world.registry.bits(["glass"])

    simulate(world).run(2.0)

    assert world.physics.scan(AHEAD, (0, 0, 0), 9.0, ground)[0].tolist() == [2.0]
    assert world.physics.scan(AHEAD, (0, 0, 0), 9.0, glass)[0].tolist() == [math.inf]
    assert robot.pose.x == pytest.approx(1.9, abs=0.01)
    assert glider.pose.x == pytest.approx(3.0, abs=1e-3)


def test_added_walls_are_part_of_their_layer(models):
    world = models.load(TWO_LAYERS)
    more = np.array([[0.0, 0.0, 1.0, 1.0], [1.0, 1.0, 2.0, 0.0]])

    world.add_walls("ground", WALL)
    world.add_walls("floor", np.empty((0, 4)))
    world.add_walls("floor", more)

    assert world.get_layer("ground").segments.tolist() == [*WALL.tolist(), *more.tolist()]
    assert world.get_layer("glass").segments.tolist() == []
    owners = {world.entities.owner(b.id).name for b in world.layers[0].physics_bodies}
    assert owners == {"ground"}


@pytest.mark.parametrize(
    "segments",
    [
        [[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, math.nan, 1.0]],
        [[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, math.inf, 1.0]],
        [[0.0, 0.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]],  # of no length
        [[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 1e6, 1.0]],  # too far
        [0.0, 0.0, 1.0, 1.0],  # not a list of segments
        [[0.0, 0.0, 1.0]],
    ],
)
def test_if_one_wall_is_invalid_none_is_added(models, segments):
    world = models.load(TWO_LAYERS)

    with pytest.raises(ValueError, match="must"):
        world.add_walls("ground", np.array(segments))

    assert world.physics.body_count == 0
    assert len(world.get_layer("ground").segments) == 0

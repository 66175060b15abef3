"""Footprints that change while the world runs."""

import math
import re

import numpy as np
import pytest

from flatland_server import BeamFan, Circle, Polygon
from flatland_server.exceptions import FlatlandError, StateError

BODIES = """bodies:
  - name: base
    footprints:
      - {type: circle, radius: 0.5, density: 2, layers: [a]}
      - {type: circle, radius: 0.1, center: [0.2, 0], density: 1, sensor: true}
plugins: [{type: DiffDrive, name: drive, body: base}]
"""
WORLD = """properties: {}
layers: [{name: a}, {name: b}]
models:
  - {name: robot, model: model.yaml}
  - {name: post, model: model.yaml, pose: [2, 0.1, 0]}
"""
SQUARE = Polygon(((-0.7, -0.7), (0.7, -0.7), (0.7, 0.7), (-0.7, 0.7)))


@pytest.fixture
def load(files, simulate):
    """Loads the world with two discs."""
    files.write("model.yaml", BODIES)
    return lambda: simulate(files.load(WORLD))


def range_of(world, layer: str) -> float:
    """The distance of the robot's centre from what is ahead on a layer."""
    body = world.models["robot"].base.physics_body
    lidar = body.add_lidar(BeamFan(0.0, 0.0, 1), (0.8, 0.0, 0.0), 9.0, world.registry.bits([layer]))
    return 0.8 + float(lidar.scan()[0][0])


def drive(simulation, seconds: float) -> list:
    """The poses while the robot drives into the post."""
    poses = []
    for _ in range(round(seconds / 0.005)):
        simulation.world.models["robot"].base.physics_body.velocity = (0.7, 0.0, 0.1)
        simulation.run()
        poses += [tuple(model.pose) for model in simulation.world.models.values()]
    return poses


def test_lidars_and_mass_follow_until_a_reset(load):
    world = load().world
    post = world.models["post"]
    before = range_of(world, "a"), post.base.physics_body.mass, post.radius

    post.set_footprint("base", 0, Circle((0.0, 0.1), np.float32(0.75)))
    assert range_of(world, "a") == pytest.approx(2 - math.sqrt(0.75**2 - 0.2**2), abs=1e-5)
    assert post.base.physics_body.mass == pytest.approx(
        2 * math.pi * 0.75**2 + math.pi * 0.01, rel=1e-6
    )
    assert post.radius == pytest.approx(0.85)
    post.set_footprint("base", 0, SQUARE, layers=["b"])
    assert (range_of(world, "a"), range_of(world, "b")) == (math.inf, pytest.approx(1.3))
    assert post.config.bodies[0] is post.base.config
    assert post.base.config.footprints[0].shape == SQUARE
    assert post.base.config.footprints[0].layers == ("b",)

    world.reset()
    post = world.models["post"]
    assert (range_of(world, "a"), post.base.physics_body.mass, post.radius) == before
    assert post.footprint_revision == 0


def test_a_run_goes_on_from_a_saved_state_bit_for_bit(load):
    first = load()
    drive(first, 0.5)
    for model in first.world.models.values():
        model.set_footprint("base", 0, SQUARE)
        model.set_footprint("base", 0, Circle((1 / 3, 0.0), 2 / 3), ["b", "a"])
    drive(first, 0.5)
    state = first.save_state()

    second = load().load_state(state)

    footprints = second.world.models["robot"].base.config.footprints
    assert footprints == first.world.models["robot"].base.config.footprints
    assert second.save_state() == state
    assert drive(second, 2.0) == drive(first, 2.0)
    with pytest.raises(StateError, match="cannot be restored"):
        second.load_state(state.replace(b'"body":"base","index":1', b'"body":"base","index":2'))
    with pytest.raises(StateError, match="cannot be restored"):
        second.load_state(state.replace(b'"radius":0.1,', b'"radius":-10,', 1))
    assert drive(second, 0.1) == drive(first, 0.1)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        # What a file may not have
        ({"shape": Circle((0, 0), -1)}, "[0].radius: expected a number above 0, found -1"),
        ({"shape": Circle((0, math.nan), 1)}, "[0].center: expected [x, y], found"),
        ({"shape": Polygon(((0, 0), (1, 0)))}, "[0].points: expected a list of 3 to 8 points"),
        ({"shape": Polygon(((0, 0), (1, 0), (2, 0)))}, "[0]: a polygon is too small or too thin"),
        ({"layers": ["c"]}, '[0].layers: no layer is named "c"; there are: a, b'),
        # Other wrong arguments
        ({"index": 2}, 'the body "base" has no footprint 2; it has 2, from index 0'),
        ({"index": -1}, "expected an index of a footprint that is a whole number of 0 or more"),
        ({"index": 1.0}, "expected an index of a footprint that is a whole number of 0 or more"),
        ({"body": "bas"}, 'the model has no body "bas" (did you mean "base"?); it has: base'),
        ({"shape": 0.5}, "expected a Circle or a Polygon, found 0.5"),
        ({"shape": Circle((1e4, 0), 1e-3)}, "cannot have this footprint: a footprint is too small"),
    ],
)
def test_a_wrong_footprint_is_refused_and_changes_nothing(load, wrong, message):
    model = load().world.models["robot"]
    before = model.config
    if message.startswith("["):
        message = f'the model "robot": base.footprints{message}'

    with pytest.raises(FlatlandError, match=re.escape(message)):
        model.set_footprint(**{"body": "base", "index": 0, "shape": SQUARE, **wrong})

    assert model.config is before


def test_a_crossed_polygon_becomes_its_hull_with_a_warning(load, caplog):
    model = load().world.models["robot"]

    model.set_footprint("base", 0, Polygon(((0, 0), (2, 2), (2, 0), (0, 2))))

    assert model.base.physics_body.mass == pytest.approx(4 * 2 + math.pi * 0.01, rel=1e-5)
    assert "its hull is taken" in caplog.text

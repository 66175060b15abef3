"""Laser: the nearest range that it measures, and bodies of its own model that it does not see."""

import math
from typing import Any

import numpy as np
import pytest

from flatland2d import Simulation, SimulationBatch
from flatland_server import RangeNoise
from flatland_server.exceptions import FlatlandError

POST = "{type: circle, radius: 0.1, density: 1}"
MODEL = """
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.3, density: 1, layers: []}]}
  - {name: post, pose: [0.5, 0, 0], footprints: [POST]}
  - {name: arm, pose: [-0.5, 0, 0], footprints: [POST]}
joints:
  - {type: weld, name: post, bodies: [{name: base, anchor: [0.5, 0]}, {name: post, anchor: [0, 0]}]}
  - {type: weld, name: arm, bodies: [{name: base, anchor: [-0.5, 0]}, {name: arm, anchor: [0, 0]}]}
plugins:
  - {type: DiffDrive, name: drive, body: base}
  - {type: Laser, name: laser, body: base, range: 20, KEYS
     angle: {min: 0, max: 3.141592653589793, increment: 3.141592653589793}}
""".replace("POST", POST)
"""Two beams: ahead to the post, back to the arm, each 0.4 m away."""


def robot(files: Any, keys: str = "", walls: str = "-5 -5 -5 5", **options: Any) -> Any:
    files.write("robot.model.yaml", MODEL.lstrip("\n").replace("KEYS", keys and f"{keys}, "))
    layers = (f"name: walls, map: {files.walls('walls', walls)}",)
    return files.load_models({"robot": "model: robot.model.yaml"}, layers=layers, **options)


def ranges(robot: Any) -> Any:
    return list(robot.run().last("/scan").ranges)


def test_a_laser_does_not_see_ignored_bodies(files):
    assert ranges(robot(files)) == pytest.approx([0.4, 0.4], abs=1e-5)
    assert ranges(robot(files, "ignore_bodies: [arm, base]")) == pytest.approx([0.4, 5.0], abs=1e-5)
    assert ranges(robot(files, "ignore_bodies: [arm, post]")) == [math.inf, pytest.approx(5.0)]


def test_the_bodies_of_other_robots_are_seen(files):
    """Also if they have the names of those that it ignores, and after one was deleted."""
    files.write("robot.model.yaml", MODEL.replace("KEYS", "ignore_bodies: [arm, post],"))
    entry = "model: robot.model.yaml, namespace: r{0}, pose: [{0}, 0, 0]"
    both = files.load_models({f"r{x}": entry.format(x) for x in (0, 2)})

    assert list(both.run().last("/r0/scan").ranges) == pytest.approx([1.4, math.inf], abs=1e-5)
    both.world.delete_model("r2")
    both.world.spawn_model(files.folder / "robot.model.yaml", "r3", "r3", (3.0, 0.0, 0.0))
    assert list(both.run().last("/r0/scan").ranges) == pytest.approx([2.4, math.inf], abs=1e-5)
    assert list(both.last("/r3/scan").ranges) == pytest.approx([math.inf, 2.4], abs=1e-5)


def test_returns_below_range_min_are_minus_infinity(files):
    near = robot(files, "range_min: 0.45, ignore_bodies: [arm], no_return: max")

    assert ranges(near) == [-math.inf, pytest.approx(5.0)]
    assert near.last("/scan").range_min == pytest.approx(0.45)
    assert ranges(robot(files, "range_min: 0.39")) == pytest.approx([0.4, 0.4], abs=1e-5)


def test_noise_leaves_no_range_below_the_least():
    noise = RangeNoise(7, 0.5, 2.0, 0.4)
    noisy = noise(np.array([0.5, -np.inf, np.inf] * 200, np.float32), 0).reshape(-1, 3)

    assert noisy[:, 0].min() == np.float32(0.4)
    assert noisy[:, 0].max() > 1.0
    assert (noisy[:, 1:] == [-np.inf, np.inf]).all()
    with pytest.raises(ValueError, match="least range"):
        RangeNoise(7, 0.5, 2.0, 2.1)


def test_range_min_and_ignore_bodies_act_in_batches_and_pictures(files):
    robot(files, "range_min: 0.45, ignore_bodies: [arm], noise_std_dev: 0.1").world.close()
    world = files.folder / "world.yaml"
    with Simulation(world, seed=3) as simulation, SimulationBatch(world, 3, seed=3) as batch:
        found = batch.observe().ranges
        assert found[0].tolist() == simulation.models["robot"].sensors["laser"].read().tolist()
        assert (found[:, 0] == -np.inf).all()
        assert np.isfinite(simulation.render((60, 60), sensors=True)).all()


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("ignore_bodies: [amr]", 'no body "amr" (did you mean "arm"?)'),
        ("range_min: 20", "expected less than the range, 20, found 20"),
        ("range_min: -1", "expected a number of 0 or more, found -1"),
        ("ignore_bodies: 3", 'no body "3"'),
    ],
)
def test_wrong_keys_are_refused(files, keys, message):
    with pytest.raises(FlatlandError) as caught:
        robot(files, keys)

    assert message in str(caught.value)
    assert "robot.model.yaml:" in str(caught.value)

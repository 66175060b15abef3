"""math.random in the expressions of files: drawn from the world's seed, for each expression."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from library.parts import BODY

from flatland2d import Simulation, SimulationBatch

WORLD = """\
properties: {}
layers:
  - {name: map, map: map.yaml}
  - {name: walls, map: {circles: [[0, 0, $eval 20 + math.random()]]}}
models:
  - {name: robot, model: robot.model.yaml, pose: [$eval math.random(), $eval math.random(), 0]}
"""
FILES = {
    "world.yaml": WORLD,
    "map.yaml": "segments: [[8, -5, $eval 9 + math.random(), 5]]\n",
    "robot.model.yaml": """\
bodies: [{name: base, footprints: [{type: circle, radius: $eval 0.2 + math.random(), density: 1}]}]
plugins:
  - {type: DiffDrive, name: drive, body: base}
  - {type: Laser, name: laser, body: base, range: 30, angle: {min: -3, max: 3, increment: 0.5}}
""",
}


@pytest.fixture
def world(tmp_path) -> Path:
    folder = tmp_path / "here"
    folder.mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder / "world.yaml"


def facts(simulation: Simulation) -> bytes:
    """All that is drawn: the pose, the radius, and the walls of both maps."""
    [radius] = [
        each.shape.radius for each in simulation.world.config.models[0].model.bodies[0].footprints
    ]
    walls = [layer.segments.ravel() for layer in simulation.world.layers]
    ranges = simulation.models["robot"].sensors["laser"].read()
    return np.concatenate([simulation.poses.ravel(), [radius], *walls, ranges]).tobytes()


def drawn(world, seed: int) -> bytes:
    with Simulation(world, seed=seed) as simulation:
        return facts(simulation)


def test_equal_seeds_give_equal_worlds_and_others_do_not(world):
    assert drawn(world, 1) == drawn(world, 1)
    assert len({drawn(world, seed) for seed in range(5)}) == 5


def test_each_expression_has_random_numbers_of_its_own(world):
    with Simulation(world, seed=1) as simulation:
        [(x, y, _)] = simulation.poses
        assert x != y

    more = "properties: {}  # and\n# a comment\nplugins: []\n"
    world.write_text(
        WORLD.replace("properties: {}\n", more).replace("[0, 0,", "[0, $eval math.random(2) * 0,")
    )
    with Simulation(world, seed=1) as simulation:
        assert simulation.poses[0, :2].tolist() == [x, y]


def test_the_folder_does_not_matter(world, tmp_path, monkeypatch):
    other = tmp_path / "over there" / "deeper"
    shutil.copytree(world.parent, other)
    (other / "world.yaml").rename(other / "another.yaml")

    expected = drawn(world, 3)

    assert drawn(other / "another.yaml", 3) == expected
    monkeypatch.chdir(world.parent)
    assert drawn("world.yaml", 3) == expected


def test_a_reset_draws_as_its_seed_says_and_reads_no_file(world):
    expected = {seed: drawn(world, seed) for seed in (1, 2)}
    assert expected[1] != expected[2]
    with Simulation(world, seed=1) as simulation:
        for name in FILES:
            (world.parent / name).write_text("{}")
        for seed in (2, 1):
            simulation.reset(seed)
            assert facts(simulation) == expected[seed]
            simulation.reset()
            assert facts(simulation) == expected[seed]


def test_a_saved_state_brings_its_numbers_back(world):
    with Simulation(world, seed=1) as simulation:
        y = simulation.poses[0, 1]
        simulation.models["robot"].command(0.5, 0.2)
        state = simulation.step(50).save_state()
        before = facts(simulation)
        simulation.reset(2)
        assert simulation.poses[0, 1] != y
        simulation.load_state(state)
        assert facts(simulation) == before


def test_environments_have_the_random_numbers_of_their_seeds(world):
    with SimulationBatch(world, 3, seed=5) as batch:
        observation = batch.step(np.zeros((3, 2)))
        for k in range(3):
            with Simulation(world, seed=5 + k) as simulation:
                assert np.array_equal(observation.poses[k], simulation.poses[0])
                ranges = simulation.models["robot"].sensors["laser"].read()
                assert np.array_equal(observation.ranges[k], ranges)
        batch.reset(seeds=[9, 5, 7])
        poses = batch.step(np.zeros((3, 2))).poses
    assert np.array_equal(poses[2], observation.poses[2])
    assert not np.array_equal(poses[0], observation.poses[0])


def test_expressions_in_a_dict_are_drawn_by_the_seed_too(world):
    entry = {"name": "robot", "pose": ["$eval math.random()", 0, 0], "model": {"bodies": [BODY]}}
    content = {"properties": {}, "layers": [], "models": [entry]}
    places = []
    for seed in (1, 2, 1):
        with Simulation(content, seed=seed) as simulation:
            places.append(simulation.poses[0, 0])
    with Simulation(content, seed=1) as simulation:
        entry["pose"] = [7, 7, 0]
        simulation.reset(2)
        places.append(simulation.poses[0, 0])

    assert places[0] == places[2] != places[1] == places[3]


def test_a_world_without_random_numbers_is_read_once(world, monkeypatch):
    for name, text in FILES.items():
        (world.parent / name).write_text(text.replace("math.random()", "0.5"))
    with Simulation(world, seed=1) as simulation:
        config = simulation.world.config
        simulation.reset(2)
        assert simulation.world.config is config

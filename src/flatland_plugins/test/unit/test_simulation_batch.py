"""SimulationBatch: each environment has the bits of a Simulation of the same seed."""

import math

import numpy as np
import pytest
from batch_world import WORLD

from flatland2d import BatchObservation, FlatlandError, Simulation, SimulationBatch

OFFICE = "office"
ROUNDS = 40
RESET_AT = 25


def commands(k, size):
    """The commands of environment k's robot in all rounds, shape (ROUNDS, size)."""
    rng = np.random.default_rng(k)
    return rng.uniform([-0.5, -1.5, -1.5][:size], [2.0, 1.5, 1.5][:size], (ROUNDS, size))


def start(k):
    """The robot's pose after a reset of environment k, different in each environment."""
    return np.array([-2 + 0.01 * k, -1.0 + 0.02 * k, 0.3 * k])


def run_simulation(world, k, size=2, substeps=20):
    """The observations of a Simulation with the commands and the seed of environment k."""
    rows = []
    with Simulation(world, seed=100 + k) as simulation:
        robot = simulation.models["robot"]
        index = list(simulation.models).index("robot")
        for i, command in enumerate(commands(k, size)):
            if i == RESET_AT and k % 2 == 0:
                simulation.reset(seed=500 + k)
                simulation.move("robot", start(k))
            robot.command(*command)
            collided = False
            for _ in range(substeps):
                simulation.step()
                collided |= any(touch_of_robot(each) for each in simulation.contacts)
            motion = simulation.poses[index], simulation.velocities[index], robot.local_velocity
            rows.append((robot.sensors["laser"].read(), *motion, collided, simulation.time))
    return [np.array(field) for field in zip(*rows)]


def touch_of_robot(touch):
    models = (touch.model_a, touch.model_b)
    return "robot" in models and models != ("robot", "robot") and len(touch.points) > 0


def run_batch(world, count, threads, size=2, substeps=20):
    """The observations of a batch: arrays with a row for each round and environment."""
    observations = []
    is_even = np.arange(count) % 2 == 0
    with SimulationBatch(world, count, threads=threads, seed=100) as batch:
        actions = np.stack([commands(k, size) for k in range(count)], axis=1)
        for i in range(ROUNDS):
            if i == RESET_AT:
                poses = np.stack([start(k) for k in range(count)])
                batch.reset(is_even, seeds=np.arange(500, 500 + count), poses=poses)
            observations.append(batch.step(actions[i], substeps))
    return [np.stack(field) for field in zip(*observations)]


def assert_are_simulations(found, expected):
    """Fails unless environments k of a batch are `expected[k]`, to the bit."""
    for k, references in expected.items():
        for name, array, reference in zip(BatchObservation._fields, found, references):
            assert np.array_equal(array[:, k], reference), (k, name)


@pytest.fixture(scope="module")
def noisy(world_of):
    """A world with noise, and the observations of Simulations as environments 0, 1, 6 and 63."""
    world = world_of(noise="0.02")
    return world, {k: run_simulation(world, k) for k in (0, 1, 6, 63)}


@pytest.mark.parametrize("threads", [1, 2, 4])
@pytest.mark.parametrize("count", [1, 7, 64])
def test_an_environment_equals_a_simulation_in_any_batch(noisy, count, threads):
    world, expected = noisy

    found = run_batch(world, count, threads)

    assert_are_simulations(found, {k: rows for k, rows in expected.items() if k < count})
    if count > 1:
        assert found[4].any()
        assert not found[4].all()


CROWD = """
plugins:
  - {type: Crowd, name: people, update_rate: 13, speed: 0.7, layers: [map], pedestrians: [
      {pose: [2, 0, 0], goals: [[-2, 0], [2, 0.5]], legs: true},
      {pose: [-2, -2.5, 0], goals: [[-2, 2.5], [-2.2, -2.5]], radius: 0.2},
      {pose: [2, -2, 2], goals: [[2.2, -2.2]], legs: true}]}
  - {type: Crowd, name: others, force: {noise: 0.2}, pedestrians: [
      {pose: [-2.5, 2.5, 0], goals: [[2.5, 2.5]]}]}
"""


DRAWN = """
  - {type: Crowd, name: agents, motion: orca, pedestrians: [
      {pose: [-2.5, 0.6, 0], goals: [[2.5, 2]], group: a},
      {pose: [-2.5, 1.4, 0], goals: [[2.5, 1]], group: a}]}
  - {type: Crowd, name: drawn, yields: 0.5, reaction_time: 0.2, field_of_view: 3, speed: 0.6,
     random: {count: 3, standing: 1, area: [[-2.5, -2.5], [2.5, 2.5]]}}
"""
AFTER = """
  - {type: Crowd, name: later, pedestrians: [{pose: [2.5, -2.5, 0], goals: [[2.5, 2.5]]}]}
"""
RECORDED = """
  - {type: Crowd, name: recorded, legs: true, update_rate: 17,
     recording: {file: people.csv, frame_rate: 25, start: [0, 0.3]}}
"""
MORE_WALLS = """
  - {type: RandomWall, name: more, layer: map, num_of_walls: 2, wall_wall_dist: 0.4,
     robot_name: robot}
"""
WALKERS = """  - {name: walker1, model: walker.yaml, pose: [-2, 1, 0]}
  - {name: walker2, model: walker.yaml, pose: [-1.3, -2.4, 2]}
"""
WORLDS = {
    "AckermannDrive": {"drive": "AckermannDrive"},
    "OmniDrive": {"drive": "OmniDrive"},
    "TricycleDrive": {"drive": "TricycleDrive"},
    "crowds": {"models": WORLD + CROWD, "noise": "0.02"},
    "drawn people": {"models": WORLD + CROWD + DRAWN},
    "drawn people, then others": {"models": WORLD + CROWD + DRAWN + AFTER},
    "recorded people": {"models": WORLD + CROWD + RECORDED},
    "random walls": {"models": WORLD + CROWD + MORE_WALLS},
    "pedestrians": {"models": WORLD + WALKERS, "noise": "0.02"},
    "all": {"models": WORLD + WALKERS + CROWD + MORE_WALLS, "noise": "0.02"},
}


@pytest.mark.parametrize("name", WORLDS)
def test_every_plugin_acts_as_in_a_simulation(world_of, name):
    """With calls of 7 steps, updates of crowds are due within them, at other times in each."""
    world, size = world_of(**WORLDS[name]), 3 if name == "OmniDrive" else 2
    substeps, count = (7, 7) if name == "crowds" else (20, 3)
    expected = {k: run_simulation(world, k, size, substeps) for k in {0, count // 2, count - 1}}

    for threads in (1, 2, 4):
        found = run_batch(world, count, threads, size, substeps)
        assert_are_simulations(found, expected)


@pytest.mark.parametrize("name", ["drawn people", "drawn people, then others"])
def test_worlds_differ_only_where_they_have_to(world_of, name):
    with SimulationBatch(world_of(**WORLDS[name]), 2) as batch:
        assert batch.worlds_differ == ("others" in name)  # a world for all takes half of the time


def test_each_environment_has_walls_of_its_seed(world_of):
    with SimulationBatch(world_of(**WORLDS["random walls"]), 2, seed=7) as batch:
        walls = [batch.added_walls(k) for k in range(2)]
        assert [each.shape for each in walls] == [(2, 4)] * 2
        assert not np.array_equal(*walls)
        assert np.array_equal(batch.view(1).world.layers[0].segments[-2:], walls[1])
        first = batch.observe()
        batch.reset(seeds=8)
        assert np.array_equal(batch.added_walls(0), walls[1])
        assert np.array_equal(batch.observe().ranges[0], first.ranges[1])


def test_people_without_room_are_told_as_in_a_simulation(world_of):
    crowd = "plugins: [{type: Crowd, name: drawn, random: {count: 3, area: [[-2, -2], [-1, -1]]}}]"
    world = world_of(models=WORLD + crowd)

    def is_refused(seed, open):
        try:
            open(seed)
        except FlatlandError as error:
            return "room for" in str(error)
        return False

    expected = [is_refused(k, lambda seed: Simulation(world, seed=seed).close()) for k in range(9)]
    with SimulationBatch(world, 1, seed=expected.index(False)) as batch:
        found = [is_refused(k, lambda seed: batch.reset(seeds=seed)) for k in range(9)]
    assert found == expected
    assert any(expected)


def test_an_office_is_that_of_a_simulation():
    actions = np.random.default_rng(3).uniform([0.5, -1], [2.5, 1], (30, 2, 2))
    with SimulationBatch(OFFICE, 2) as batch, Simulation(OFFICE) as simulation:
        robot = simulation.models["turtlebot"]
        for action in actions:
            observation = batch.step(action, 20)
            robot.command(*action[1])
            simulation.step(20)
            assert np.array_equal(observation.poses[1], simulation.poses[0])
            assert np.array_equal(observation.ranges[1], robot.sensors["laser"].read())


def test_scans_with_the_walls_of_a_cell_are_those_with_all(world_of):
    # Enough scans from one place for the core to have determined the walls visible there.
    with SimulationBatch(OFFICE, 1) as batch:
        first = batch.observe().ranges
        for _ in range(600):
            last = batch.observe().ranges

    assert np.array_equal(first, last)


def test_a_view_shows_an_environment_and_its_people(world_of):
    actions = commands(5, 2)[:, None] * np.ones((3, 1))
    world = world_of(noise="0.02", models=WORLD + CROWD)
    with SimulationBatch(world, 3, seed=7) as batch, Simulation(world, seed=8) as simulation:
        for action in actions[:15]:
            observation = batch.step(action, 20)
            simulation.models["robot"].command(*action[1])
            simulation.step(20)
        for k in (0, 2, 1):
            view = batch.view(k)
            robot = view.models["robot"]
            assert np.array_equal(robot.pose, observation.poses[k])
            assert np.array_equal(robot.sensors["laser"].read(), observation.ranges[k])
            assert view.time == observation.times[k]
        assert np.array_equal(view.poses, simulation.poses)
        assert np.array_equal(view.render(sensors=True), simulation.render(sensors=True))
        assert math.dist(view.models["people_0"].pose[:2], (2, 0)) > 0.5


def test_environments_that_are_not_stepped_stay_as_they_are(world_of):
    """Each makes its steps in calls of its own, as if all were stepped in each call."""
    count, rounds = 5, 12
    world = world_of(noise="0.02", models=WORLD + CROWD + MORE_WALLS)
    actions = np.stack([commands(k, 2)[:rounds] for k in range(count)], axis=1)
    with SimulationBatch(world, count, seed=3) as batch:
        expected = [batch.observe()] + [batch.step(each, 7) for each in actions]

    for threads in (1, 2):
        rng, made = np.random.default_rng(1), np.zeros(count, int)
        with SimulationBatch(world, count, seed=3, threads=threads) as batch:
            out = batch.observe()
            while made.min() < rounds:
                mask = (rng.random(count) < 0.4) & (made < rounds)
                present = np.full((count, 2), math.nan)
                for k in np.flatnonzero(mask):
                    present[k] = actions[made[k], k]
                batch.step(present, 7, out, mask)
                made += mask
                for field, array in enumerate(out):
                    rows = [expected[made[k]][field][k] for k in range(count)]
                    assert np.array_equal(array, rows), field
            for array, kept in zip(batch.step(present, 7, mask=np.zeros(count, bool)), out):
                assert np.array_equal(array, kept)

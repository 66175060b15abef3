"""States of batches and branches of a simulation: each goes on with the bits of the simulation."""

import copy
import pickle

import numpy as np
import pytest
from batch_world import WORLD

from flatland2d import Simulation, SimulationBatch, UsageError, world_content
from flatland_server import (
    BatchMotion,
    BatchRole,
    Circle,
    PluginLoader,
    Polygon,
    UpdateTimer,
    WorldPlugin,
    plain_data,
)
from flatland_server.exceptions import StateError

COUNT = 5
CROWD = """
plugins:
  - {type: Crowd, name: people, update_rate: 13, force: {noise: 0.2}, pedestrians: [
      {name: ann, pose: [2, 0, 0], goals: [[-2, 0], [2, 0.5]], legs: true},
      {name: bob, pose: [-2, -2.5, 0], goals: [[-2, 2.5], [-2.2, -2.5]], radius: 0.2}]}
"""
RECORDED = """
plugins:
  - {type: Crowd, name: people, recording: {file: people.csv, frame_rate: 20}}
"""
RANDOM_WALLS = """
plugins:
  - {type: RandomWall, name: walls, layer: map, num_of_walls: 2, wall_wall_dist: 0.5,
     robot_name: robot}
"""
WORLDS = {
    "DiffDrive": {},
    "AckermannDrive": {"drive": "AckermannDrive"},
    "OmniDrive": {"drive": "OmniDrive"},
    "TricycleDrive": {"drive": "TricycleDrive"},
    "crowd": {"models": WORLD + CROWD},
    "recorded people": {"models": WORLD + RECORDED},
    "pedestrian": {"models": WORLD + "  - {name: walker, model: walker.yaml, pose: [2, 0.5, 0]}\n"},
    "random walls": {"models": WORLD + RANDOM_WALLS},
}


@pytest.fixture(params=WORLDS)
def world(request, world_of):
    """A world of each drive, one with people, and one with walls that depend on the seed."""
    return world_of(noise="0.02", **WORLDS[request.param])


def drive(simulation, rounds, seed=0, steps=7):
    """Drives at random, into walls and boxes; returns what the robot observes in each round."""
    robot, rng = simulation.models["robot"], np.random.default_rng(seed)
    index = list(simulation.models).index("robot")
    rows = []
    for command in actions_of(simulation, rounds, rng):
        robot.command(*command)
        simulation.step(steps)
        laser = robot.sensors["laser"].read()
        rows.append((laser, simulation.poses[index], simulation.velocities[index], simulation.time))
    return rows


def actions_of(simulation, rounds, rng):
    size = 3 if simulation.models["robot"].plugin("drive").type == "OmniDrive" else 2
    return rng.uniform([-0.5, -1.5, -1.5][:size], [2.0, 1.5, 1.5][:size], (rounds, size))


def assert_goes_on(batch, simulation, rounds=20, steps=7, seed=1):
    """Fails unless all environments are the simulation, with the same commands, to the bit."""
    rng = np.random.default_rng(seed)
    actions = actions_of(simulation, rounds, rng)
    found = [batch.step(np.tile(each, (batch.num_envs, 1)), steps) for each in actions]
    expected = drive(simulation, rounds, seed, steps)
    for observation, rows in zip(found, expected):
        fields = observation.ranges, observation.poses, observation.velocities, observation.times
        for array, row in zip(fields, rows):
            assert (array == row).all()


def physics(state):
    return plain_data.loads(state)["physics"]


@pytest.mark.slow
@pytest.mark.parametrize("rounds", [0, 1, 40])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_branch_is_what_the_simulation_would_be(world, rounds, threads):
    with Simulation(world, seed=4) as simulation, Simulation(world, seed=4) as untouched:
        drive(simulation, rounds), drive(untouched, rounds)
        with simulation.branch(COUNT, threads=threads) as batch:
            assert np.array_equal(batch.seeds, np.full(COUNT, 4))
            for _ in range(2):
                assert_goes_on(batch, simulation)
                batch.reset()  # to where they have branched off
                simulation.reset()
                drive(simulation, rounds)
        assert_goes_on_alike(simulation, untouched)


def assert_goes_on_alike(simulation, other):
    for row, expected in zip(drive(simulation, 20, 2), drive(other, 20, 2)):
        assert all(np.array_equal(*each) for each in zip(row, expected))
    assert physics(simulation.save_state()) == physics(other.save_state())


@pytest.mark.slow
def test_a_state_goes_from_a_simulation_to_a_batch_and_back(world):
    with Simulation(world, seed=8) as simulation, SimulationBatch(world, COUNT, threads=2) as batch:
        drive(simulation, 40)
        state = simulation.save_state()

        batch.load_states(state)
        back = batch.save_states()

        assert len(back) == COUNT
        assert len({physics(each) for each in back}) == 1
        assert_goes_on(batch, simulation)
        for k, each in enumerate(batch.save_states()):
            with Simulation(world) as other:
                other.load_state(each)
                assert other.seed == 8
                assert np.array_equal(other.poses, simulation.poses), k
                assert np.array_equal(other.velocities, simulation.velocities), k
                drive(other, 3)


@pytest.mark.slow
def test_each_environment_has_its_own_state(world):
    with SimulationBatch(world, COUNT, seed=20, threads=2) as batch:
        rng = np.random.default_rng(3)
        shape = (COUNT, len(batch.action_names))
        for _ in range(20):
            batch.step(rng.uniform(-0.5, 1.5, shape), 9)
        states = batch.save_states()
        actions = rng.uniform(-0.5, 1.5, (10, *shape))
        expected = [batch.step(each, 9) for each in actions]
        assert len(set(states)) == COUNT
        assert batch.save_states(np.arange(COUNT) == 3) == [batch.save_states()[3]]

        batch.reset(seeds=50)
        batch.load_states(states)
        found = [batch.step(each, 9) for each in actions]

        for one, other in zip(found, expected):
            assert all(np.array_equal(*each) for each in zip(one, other))
        assert np.array_equal(batch.seeds, np.arange(20, 20 + COUNT))


def test_a_mask_chooses_what_is_loaded(world_of):
    with SimulationBatch(world_of(), COUNT) as batch:
        batch.step(np.full((COUNT, 2), 0.5), 40)
        [state] = batch.save_states(np.arange(COUNT) == 2)
        before = batch.step(np.full((COUNT, 2), -0.5), 40)
        mask = np.arange(COUNT) % 2 == 0

        after = batch.load_states(state, mask)

        assert (after.times[mask] == 0.2).all()
        assert (after.ranges[mask] == after.ranges[2]).all()
        for array, former in zip(after, before):
            assert np.array_equal(array[~mask], former[~mask])
        out = before.copy()
        assert batch.load_states([state] * 3, mask, out) is out
        assert all(np.array_equal(*each) for each in zip(out, after))
        nobody = np.zeros(COUNT, bool)
        assert batch.save_states(nobody) == []
        batch.load_states([], nobody)


def test_several_robots_go_on_from_states(world_of):
    """In a batch, in a simulation and in its branches; one of them was commanded to stop."""
    world = world_content(world_of(noise="0.02"))
    [robot] = [each for each in world["models"] if each["name"] == "robot"]
    world["models"].append({**robot, "name": "other", "namespace": "other", "pose": [0, -2, 1]})
    names, rng = ["robot", "other"], np.random.default_rng(1)
    actions = rng.uniform([-0.5, -1.5], [2.0, 1.5], (20, COUNT, 2, 2))
    with SimulationBatch(world, COUNT, robots=names, seed=3) as batch, Simulation(world) as single:
        for each in actions:
            batch.step(each, 7)
        batch.step(actions[0], 7, mask=np.arange(2 * COUNT).reshape(COUNT, 2) % 3 > 0)
        states = batch.save_states()
        expected = [batch.step(each, 7) for each in actions]
        batch.load_states(states)
        for each, row in zip(actions, expected):
            found = batch.step(each, 7)
            assert all(np.array_equal(*arrays) for arrays in zip(found, row))
        single.load_state(states[2])
        with single.branch(2, robots=names) as branches:
            for each, row in zip(actions, expected):
                found = branches.step(each[[2, 2]], 7)
                for array, of_all in zip(found, row):
                    assert (array == of_all[2]).all()


DISC = {"type": "circle", "radius": 0.15, "density": 5.0}
BOX = {"bodies": [{"name": "body", "footprints": [DISC], "linear_damping": 2.0}]}


def test_branches_have_spawned_models_and_no_deleted_ones(world_of):
    world = world_of()
    with Simulation(world) as simulation:
        name = next(each for each in simulation.models if each != "robot")
        simulation.delete(name)
        robot = simulation.models["robot"].pose
        simulation.spawn(BOX, "crate", (robot.x + 0.6, robot.y, 0.0))
        drive(simulation, 10)
        state = simulation.save_state()
        with simulation.branch(2) as batch:
            shown = batch.view(1)
            assert list(shown.models) == list(simulation.models)
            assert np.array_equal(shown.poses, simulation.poses)
            assert_goes_on(batch, simulation)
            batch.load_states(simulation.save_state())  # on to where the simulation is
            assert_goes_on(batch, simulation)
            batch.load_states(state)
        with SimulationBatch(world, 2) as batch:
            before = batch.save_states()
            with pytest.raises(
                StateError, match="another world: models were added, changed or deleted"
            ):
                batch.load_states(state)
            assert batch.save_states() == before


@pytest.mark.parametrize("shape", [Circle((0.05, 0.0), 0.4), Polygon(((-1, -1), (1, -1), (0, 1)))])
def test_branches_have_changed_footprints(world_of, shape):
    """The robot's and a box's: they are seen, and hit things."""
    world = world_of(noise="0.02")
    with Simulation(world, seed=2) as simulation:
        simulation.models["robot"].model.set_footprint("base", 0, Circle((0.1, 0.0), 0.35))
        box = simulation.models["box1"].model
        box.set_footprint(next(iter(box.bodies)), 0, shape)
        drive(simulation, 10)
        state = simulation.save_state()
        with simulation.branch(3) as batch:
            assert_goes_on(batch, simulation)
            saved = batch.save_states()[1]
            batch.reset()
            simulation.load_state(state)
            assert_goes_on(batch, simulation, seed=5)
        with Simulation(world) as other:
            assert np.array_equal(other.load_state(saved).poses[0], other.poses[0])
            assert other.models["robot"].model.footprint_revision
        unlike = pytest.raises(StateError, match="another world: footprints were")
        with SimulationBatch(world, 2) as batch, unlike:
            batch.load_states(state)


def damaged(state, **changes):
    return plain_data.dumps({**plain_data.loads(state), **changes})


def test_a_foreign_or_broken_state_is_refused_without_effect(world_of):
    world = world_of()
    with SimulationBatch(world, 3) as batch:
        batch.step(np.full((3, 2), 0.4), 40)
        before = batch.save_states()
        state = before[0]
        broken = physics(state)[:-1]
        with Simulation(world_of(noise="0.01", drive="TricycleDrive")) as other:
            of_another = other.save_state()
        for wrong, error, message in [
            (b"", StateError, "expected the state of a world, found something else"),
            (damaged(state, physics=broken), StateError, "the state is damaged"),
            (damaged(state, seed=2**63), StateError, "expected a state with a seed of 0 to 2"),
            (damaged(state, nanoseconds=1), StateError, "after whole steps of 0.005 s, found one"),
            (of_another, StateError, "another world"),
            ([state], UsageError, "expected 3 states, found 1"),
            ([state, state, 5], UsageError, "expected states as bytes"),
            ("state", UsageError, "expected states as bytes"),
            (None, UsageError, "expected states as bytes"),
        ]:
            with pytest.raises(error, match=message):
                batch.load_states(wrong)
        with pytest.raises(StateError, match="the state is damaged"):
            batch.load_states([state, damaged(state, physics=broken), state])
        assert batch.save_states() == before
    with pytest.raises(UsageError, match="closed"):
        batch.save_states()
    with pytest.raises(UsageError, match="closed"):
        batch.load_states(state)


def test_branches_with_random_walls_keep_them(world_of):
    world = world_of(**WORLDS["random walls"])
    with Simulation(world, seed=2) as other:
        state = other.save_state()
    simulation = Simulation(world, seed=1)
    with simulation.branch(2) as batch:
        simulation.close()  # the branches go on without it
        with pytest.raises(StateError, match="expected a state with the seed 1"):
            batch.load_states(state)
        batch.load_states(batch.save_states())


def test_a_static_body_that_has_moved_is_not_exchanged(world_of):
    pillar = {"bodies": [{**BOX["bodies"][0], "type": "static"}]}
    with Simulation(world_of()) as simulation:
        simulation.spawn(pillar, "pillar", (2.0, 2.0, 0.0))
        with simulation.branch(2) as batch:
            simulation.move("pillar", (1.5, 2.0, 0.0))
            with pytest.raises(StateError, match="a static body is elsewhere"):
                batch.load_states(simulation.save_state())
        with simulation.branch(2) as batch:
            assert_goes_on(batch, simulation)


def test_simulations_and_batches_are_not_copied(world_of):
    with Simulation(world_of()) as simulation, simulation.branch(1) as batch:
        for each in (simulation, batch):
            for copied in (copy.deepcopy, pickle.dumps):
                with pytest.raises(UsageError, match="neither copied nor pickled"):
                    copied(each)


def test_worlds_that_batches_cannot_run_have_no_branches(world_of):
    with Simulation(world_of()) as simulation:
        with pytest.raises(UsageError, match="a number of environments"):
            simulation.branch(0)
        simulation.delete("robot")
        with pytest.raises(Exception, match="expected a model with a drive and a lidar"):
            simulation.branch(2)
    with pytest.raises(UsageError, match="closed"):
        simulation.branch(2)


class Sway(BatchMotion):
    """Moves a box to and fro, by fits and starts."""

    def __init__(self, body, count):
        super().__init__(rate=11.0)
        self.bodies = self.moved = [body]
        self.phases, self.rngs = np.zeros(count), [None] * count

    def begin(self, environment, rng, walls):
        self.phases[environment], self.rngs[environment] = 0.0, rng

    def update(self, environments, poses, velocities, step_size):
        moved = np.zeros((len(environments), 1, 3))
        for row, k in zip(moved, environments.tolist()):
            self.phases[k] += self.rngs[k].random()
            row[0, 0] = 0.3 * np.sin(self.phases[k])
        return moved

    def get_state(self, environment):
        return float(self.phases[environment])

    def set_state(self, environment, state):
        self.phases[environment] = state


class Swayer(WorldPlugin):
    def on_initialize(self, config):
        self.body = self.world.get_model("box1").base.physics_body
        self.update_timer = UpdateTimer(11.0)
        self.motion = Sway(self.body, 1)
        self.motion.begin(0, self.rng, None)

    def before_physics_step(self, timekeeper):
        [[velocity]] = self.motion.update(np.array([0]), None, None, timekeeper.step_size)
        self.body.velocity = tuple(velocity)

    @property
    def batch_role(self):
        return BatchRole(make_motion=lambda count: Sway(self.body, count))

    def get_state(self):
        return self.motion.get_state(0)

    def set_state(self, state):
        self.motion.set_state(0, state)


class Loader(PluginLoader):
    def load(self, type, base):
        return Swayer if type == "Swayer" else super().load(type, base)


def test_plugins_that_move_bodies_go_on_from_their_states(world_of, monkeypatch):
    world = world_of(models=WORLD + "plugins: [{type: Swayer, name: sway}]\n")
    with Simulation(world, seed=5, loader=Loader()) as simulation:
        drive(simulation, 9)
        with simulation.branch(3) as batch:
            for _ in range(2):
                actions = np.full((3, 2), 0.3)
                for _ in range(12):
                    batch.step(actions, 13)
                shown = batch.view(2).poses
                batch.reset()
            [state] = batch.save_states(np.arange(3) == 1)
            robot = simulation.models["robot"]
            for _ in range(12):
                robot.command(0.3, 0.3)
                simulation.step(13)
            assert np.array_equal(shown, simulation.poses)
            simulation.load_state(state)
            assert_goes_on(batch, simulation)
            monkeypatch.setattr(Sway, "get_state", BatchMotion.get_state)
            with pytest.raises(StateError, match='"sway": NotImplementedError: Sway has no get_st'):
                batch.save_states()

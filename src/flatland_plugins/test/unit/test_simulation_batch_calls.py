"""Arguments and results of a SimulationBatch; wrong arguments change nothing."""

import math

import numpy as np
import pytest
from batch_world import WALLS, WORLD

from flatland2d import (
    BatchObservation,
    ModelError,
    PluginError,
    Simulation,
    SimulationBatch,
    UsageError,
)
from flatland_server import BatchRole, Circle, ModelPlugin, PluginLoader


def test_facts_of_the_robot(world_of):
    with SimulationBatch(world_of("TricycleDrive"), 3, threads=2, seed=[5, 3, 9]) as batch:
        assert (batch.num_envs, batch.threads, batch.robot) == (3, 2, "robot")
        assert batch.action_names == ("speed", "steer_angle")
        assert batch.action_limits.tolist() == [[-math.inf, -0.7], [math.inf, 0.7]]
        assert (batch.beams, batch.max_range, batch.step_size) == (81, 6.0, 0.005)
        assert batch.seeds.tolist() == [5, 3, 9]


def test_observations_are_new_arrays_unless_out_is_passed(world_of):
    with SimulationBatch(world_of(), 4) as batch:
        actions = np.full((4, 2), 0.5, np.float32)
        first = batch.step(actions)
        before = first.copy()
        out = BatchObservation.empty(4, batch.beams)

        assert batch.step(actions, out=out) is out

        for array, kept in zip(first, before):
            assert np.array_equal(array, kept)
        assert not np.array_equal(out.poses, first.poses)
        assert out.times.tolist() == [2 * batch.step_size] * 4


def test_a_reset_writes_the_rows_of_those_that_are_reset(world_of):
    with SimulationBatch(world_of(), 3) as batch:
        initial = batch.reset()
        out = batch.step(np.ones((3, 2)))
        before = out.copy()

        batch.reset(np.array([False, True, False]), out=out)

        for name, array, kept, fresh in zip(out._fields, out, before, initial):
            assert np.array_equal(array[[0, 2]], kept[[0, 2]]), name
            assert np.array_equal(array[1], fresh[1]), name
        for array, present in zip(out, batch.observe()):
            assert np.array_equal(array, present)
        for array, present in zip(batch.reset(np.zeros(3, bool)), out):
            assert np.array_equal(array, present)


def test_free_poses_are_as_far_from_walls_and_boxes_as_asked_for(world_of):
    with SimulationBatch(world_of(), 200) as batch:
        poses = batch.free_poses(200, 0.4, np.random.default_rng(0))
        observation = batch.reset(poses=poses)

        walls = np.array([[float(number) for number in wall.split()] for wall in WALLS])
        way = walls[:, 2:] - walls[:, :2]
        offset = poses[:, None, :2] - walls[:, :2]
        part = (np.einsum("nwi,wi->nw", offset, way) / (way**2).sum(axis=1)).clip(0, 1)
        distances = np.linalg.norm(offset - part[..., None] * way, axis=2)
        assert distances.min() >= 0.4
        boxes = np.array([[1, -1], [0, 0.1], [0, -0.35]])
        assert np.linalg.norm(poses[:, None, :2] - boxes, axis=2).min() >= 0.4 + 0.2
        assert (np.abs(poses[:, :2]) < 3).all()
        assert not batch.step(np.zeros((200, 2)), 1).collided.any()
        assert not observation.collided.any()
        space = batch.free_space(0.4)
        assert space.contains(poses).all()
        assert not space.contains(np.array([[0.0, 2.0], [9.0, 9.0], [-2.9, 0.0]])).any()


def unusable():
    """Calls that are wrong, each with a part of the message."""
    ones = np.ones((2, 2))
    small = BatchObservation.empty(1, 81)
    whole = BatchObservation.empty(2, 81)
    whole.poses.flags.writeable = False
    return [
        (lambda b: b.step([[1, 2]]), "shape (2, 2): speed, yaw_rate, found shape (1, 2)"),
        (lambda b: b.step([[1, 2], [3]]), "actions of"),
        (lambda b: b.step("forwards"), "found shape ()"),
        (lambda b: b.step(ones * [1, math.nan]), "found [1, nan] for environment 0"),
        (lambda b: b.step(ones * [[1], [math.inf]]), "for environment 1"),
        (lambda b: b.step(ones.astype(complex)), "complex128"),
        (lambda b: b.step(ones.astype(bool)), "found bool"),
        (lambda b: b.step(ones.astype(object)), "found object"),
        (lambda b: b.step(ones, 0), "a number of steps"),
        (lambda b: b.step(ones, 10**30), "expected at most 2147483647 steps"),
        (lambda b: b.step(ones, out=small), "expected out.ranges as float32 of shape (2, 81)"),
        (lambda b: b.step(ones, out=whole), "out.poses"),
        (lambda b: b.step(ones, out=()), "BatchObservation"),
        (lambda b: b.step(ones, mask=[0, 1]), "a mask of bool"),
        (lambda b: b.step(ones, mask=np.ones(3, bool)), "shape (2,)"),
        (lambda b: b.step(ones * math.nan, mask=[False, True]), "[nan, nan] for environment 1"),
        (lambda b: b.reset([0, 1]), "a mask of bool"),
        (lambda b: b.reset(np.ones(3, bool)), "shape (2,)"),
        (lambda b: b.reset(seeds=[1, -1]), "seeds"),
        (lambda b: b.reset(seeds=-1), "seed"),
        (lambda b: b.reset(poses=np.full((2, 3), 1e30)), "poses of finite numbers"),
        (lambda b: b.reset(poses=[1, 2, 3]), "x, y, yaw"),
        (lambda b: b.move([1, 2, 3]), "x, y, yaw"),
        (lambda b: b.move(np.full((2, 3), 1e30)), "poses of finite numbers up to 50000"),
        (lambda b: b.view(2), "expected an environment from 0 to 1, found 2"),
        (lambda b: b.view(True), "expected an environment from 0 to 1, found True"),
        (lambda b: b.added_walls(2), "expected an environment from 0 to 1, found 2"),
        (lambda b: b.view("1"), "found '1'"),
        (lambda b: b.free_poses(1, 0.0, np.random.default_rng(0)), "clearance"),
        (lambda b: b.free_space(None), "expected a clearance above zero, found None"),
        (lambda b: b.free_space(10**400), "expected a clearance above zero, found 1000"),
        (lambda b: b.free_space([0.3]), "expected a clearance above zero, found [0.3]"),
        (lambda b: b.free_space(0.3).contains(np.zeros(2)), "points of shape (n, 2), found (2,)"),
        (lambda b: b.free_poses(1, 50.0, np.random.default_rng(0)), "clearance of 50 m"),
    ]


@pytest.mark.parametrize("index", range(len(unusable())))
def test_wrong_arguments_change_nothing(world_of, index):
    call, message = unusable()[index]
    with SimulationBatch(world_of(), 2) as batch:
        before = batch.step(np.ones((2, 2)))

        with pytest.raises(UsageError) as error:
            call(batch)

        assert message in str(error.value)
        for array, kept in zip(batch.observe(), before):
            assert np.array_equal(array, kept)


def test_poses_of_environments_that_are_not_reset_do_not_matter(world_of):
    with SimulationBatch(world_of(), 2) as batch:
        observation = batch.reset(
            np.array([True, False]), poses=[[-2, 0, 0], [math.nan, math.nan, math.nan]]
        )

        assert observation.poses[0, 0] == pytest.approx(-1.95)


def test_worlds_that_have_no_robot_are_refused(world_of):
    two = WORLD + "  - {name: other, model: robot.yaml, pose: [2, 2, 0]}\n"
    none = WORLD.replace("model: robot.yaml", "model: box.yaml")

    with pytest.raises(ModelError, match=r"expected a model with a drive and a lidar, found box1"):
        SimulationBatch(world_of(models=none), 1)
    with pytest.raises(ModelError, match=r"found robot, other: say which \(robot=...\)"):
        SimulationBatch(world_of(models=two), 1)
    with pytest.raises(ModelError, match='"box1" has: none'):
        SimulationBatch(world_of(), 1, robot="box1")
    with pytest.raises(ModelError, match=r'no lidar "lasr" \(did you mean "laser"'):
        SimulationBatch(world_of(), 1, lidar="lasr")
    with SimulationBatch(world_of(models=two), 1, robot="other", lidar="laser") as batch:
        assert batch.robot == "other"


class Observer(ModelPlugin):
    batch_role = BatchRole()

    def on_initialize(self, config):
        pass

    def before_physics_step(self, timekeeper):
        pass


class Quiet(Observer):
    pass


class Actor(Observer):
    def after_physics_step(self, timekeeper):
        pass


class Hooks:
    def begin_contact(self, contact):
        pass


class MixedActor(Hooks, Observer):
    pass


class Refused(Observer):
    batch_role = None


GROWER = "\n  - {type: Grower, name: grower}"


class Grower(Observer):
    """Changes a footprint when it starts, with some seeds."""

    batch_role = BatchRole(varies_by_seed=True)

    def on_initialize(self, config):
        if self.rng.random() < 0.5:
            self.model.set_footprint("base", 0, Circle((0.0, 0.0), 0.3))


LOCAL = {each.__name__: each for each in (Observer, Quiet, Actor, MixedActor, Refused, Grower)}


class Loader(PluginLoader):
    def load(self, type, base):
        return LOCAL.get(type) or super().load(type, base)


@pytest.mark.parametrize("name", ["Actor", "MixedActor", "Refused"])
def test_plugins_without_a_role_are_refused_by_name(world_of, name):
    """A class that overrides a hook has to declare its role again."""
    roles = "\n  - {type: Observer, name: eye}\n  - {type: Quiet, name: quiet}"
    SimulationBatch(world_of(others=roles), 1, loader=Loader()).close()
    with pytest.raises(PluginError, match=rf'"robot/hand" \({name}\) acts in Python'):
        SimulationBatch(world_of(others=f"\n  - {{type: {name}, name: hand}}"), 1, loader=Loader())


def test_footprints_that_are_not_those_of_the_files_are_refused(world_of):
    def open_with(seeds):
        world = world_of(others=GROWER)
        with SimulationBatch(world, len(seeds), seed=seeds, loader=Loader()) as batch:
            batch.reset()

    def grows(seed):
        with Simulation(world_of(others=GROWER), seed=seed, loader=Loader()) as simulation:
            return simulation.world.models["robot"].footprint_revision > 0

    growing = next(seed for seed in range(99) if grows(seed))
    other = next(seed for seed in range(99) if not grows(seed))
    open_with([other, other])
    for seeds in [growing], [other, growing]:
        with pytest.raises(PluginError, match="a plugin has changed those of robot"):
            open_with(seeds)


@pytest.mark.parametrize(
    "arguments", [{"num_envs": 0}, {"threads": 0}, {"step_size": -1.0}, {"params": 3}]
)
def test_wrong_numbers_are_refused(world_of, arguments):
    with pytest.raises(UsageError):
        SimulationBatch(world_of(), **{"num_envs": 2, **arguments})


def test_a_closed_batch_says_so(world_of):
    batch = SimulationBatch(world_of(), 1)
    batch.close()

    with pytest.raises(UsageError, match="the batch is closed"):
        batch.step(np.ones((1, 2)))

"""SimulationBatch with several robots in each environment: the bits of a Simulation with them."""

import math

import numpy as np
import pytest
from batch_world import WORLD

from flatland2d import BatchObservation, ModelError, Simulation, SimulationBatch, UsageError

ROBOTS = ("robot", "second", "third")
SUBSTEPS = 20
MOVED_AT, LEFT_OUT_FROM, RESET_AT, ROUNDS = 10, 20, 30, 40
AWAY = [2.0, -2.0, 0.7]
TEAM = f"""{WORLD}
  - {{name: second, namespace: second, model: robot.yaml, pose: [-1.5, 1, -0.7]}}
  - {{name: third, namespace: third, model: robot.yaml, pose: [-2, -1, 0.5]}}
"""


def commands(k):
    """The commands of environment k's robots, shape (ROUNDS, 3, 2)."""
    return np.random.default_rng(k).uniform([-0.5, -1.5], [2.0, 1.5], (ROUNDS, 3, 2))


def starts(k):
    """The robots' poses after the reset of environment k."""
    return np.array([[-2 + 0.1 * k, -1, 0], [2, 0.1 * k, 3], [1, -2, 0.3 * k]])


def run_simulation(world, k):
    """A Simulation with the commands of environment k: for each round, what its robots observe."""
    rounds = []
    with Simulation(world, seed=100 + k) as simulation:
        models = [simulation.models[name] for name in ROBOTS]
        for i, of_robots in enumerate(commands(k)):
            if i == MOVED_AT and k % 2 == 0:
                simulation.move("second", AWAY)
            if i == RESET_AT:
                simulation.reset(seed=500 + k)
                for name, pose in zip(ROBOTS, starts(k)):
                    simulation.move(name, pose)
            for number, (model, command) in enumerate(zip(models, of_robots)):
                model.command(*(command if is_driven(i, number) else (0.0, 0.0)))
            touched = np.zeros(3, bool)
            for _ in range(SUBSTEPS):
                simulation.step()
                for touch in simulation.contacts:
                    for number, name in enumerate(ROBOTS):
                        other = {touch.model_a, touch.model_b}
                        touched[number] |= name in other and len(other) > 1 and len(touch.points)
            index = [list(simulation.models).index(name) for name in ROBOTS]
            ranges = np.array([model.sensors["laser"].read() for model in models])
            local = np.array([model.local_velocity for model in models])
            motion = simulation.poses[index], simulation.velocities[index], local
            rounds.append((ranges, *motion, touched))
    return rounds


def is_driven(i, number):
    """True if a robot is in the mask of a round."""
    return number != 1 or not LEFT_OUT_FROM <= i < RESET_AT


@pytest.mark.parametrize("drive", ["DiffDrive", "TricycleDrive"])
def test_robots_are_those_of_a_simulation(world_of, drive):
    world, count = world_of(drive, noise="0.02", models=TEAM), 5
    expected = [run_simulation(world, k) for k in range(count)]
    actions = np.stack([commands(k) for k in range(count)], axis=1)
    touched = np.zeros(3, bool)
    for threads in (1, 3):
        with SimulationBatch(world, count, robots=ROBOTS, threads=threads, seed=100) as batch:
            assert batch.robots == ROBOTS
            out = batch.observe()
            for i in range(ROUNDS):
                if i == MOVED_AT:
                    poses, mask = np.full((count, 3, 3), math.nan), np.zeros((count, 3), bool)
                    poses[::2, 1], mask[::2, 1] = AWAY, True
                    batch.move(poses, mask)
                if i == RESET_AT:
                    poses = np.stack([starts(k) for k in range(count)])
                    batch.reset(seeds=np.arange(500, 500 + count), poses=poses)
                mask = np.array([[is_driven(i, number) for number in range(3)]] * count)
                values = np.where(mask[..., None], actions[i], math.nan)
                before = out.copy()
                batch.step(values, SUBSTEPS, out=out, mask=None if mask.all() else mask)
                whole = batch.observe()
                for k in range(count):
                    for name, array in zip(BatchObservation._fields, expected[k][i]):
                        for number in range(3):
                            row = getattr(out, name)[k, number]
                            kept = getattr(before, name)[k, number]
                            right = array[number] if mask[k, number] else kept
                            assert np.array_equal(row, right), (i, k, name, number)
                            assert np.array_equal(getattr(whole, name)[k, number], array[number])
                touched |= out.collided.any(axis=0)
    assert touched.all()


def test_a_mask_of_environments_chooses_all_of_their_robots(world_of):
    with SimulationBatch(world_of(models=TEAM), 3, robots=ROBOTS) as batch:
        ones = np.ones((3, 3, 2))
        before = batch.observe()
        after = batch.step(ones, 5, mask=[False, True, False])
        assert after.times.tolist() == [0, 5 * batch.step_size, 0]
        assert (after.poses[1] != before.poses[1]).any(axis=1).all()
        assert np.array_equal(after.poses[[0, 2]], before.poses[[0, 2]])
        none = batch.step(ones * math.nan, mask=np.zeros((3, 3), bool))
        assert np.array_equal(none.ranges, after.ranges)


def test_one_robot_in_a_list_has_an_axis(world_of):
    with SimulationBatch(world_of(), 2) as batch:
        expected = batch.step(np.ones((2, 2)))
    with SimulationBatch(world_of(), 2, robots=["robot"]) as team:
        found = team.step(np.ones((2, 1, 2)))
    for array, other in zip(found[:5], expected[:5]):
        assert np.array_equal(array[:, 0], other)
    assert found.times.shape == (2,)


def wrong_calls():
    """Calls that are wrong, each with a part of the message."""
    ones = np.ones((2, 3, 2))
    poses = np.zeros((2, 3, 3))
    return [
        (lambda b: b.step(np.ones((2, 2))), "shape (2, 3, 2): speed, yaw_rate, found shape (2, 2)"),
        (lambda b: b.step(ones * math.nan), "[nan, nan] for robot 0 of environment 0"),
        (lambda b: b.step(ones, mask=np.ones((2, 2), bool)), "shape (2,) or (2, 3) of bool"),
        (lambda b: b.step(ones, mask=np.ones(3, bool)), "shape (2,) or (2, 3) of bool"),
        (lambda b: b.step(ones, out=BatchObservation.empty(2, 81)), "float32 of shape (2, 3, 81)"),
        (lambda b: b.reset(poses=poses[:, 0]), "poses of shape (2, 3, 3)"),
        (lambda b: b.reset(mask=np.ones((2, 3), bool)), "a mask of shape (2,) of bool"),
        (lambda b: b.move(poses[:, 0]), "poses of shape (2, 3, 3)"),
        (lambda b: b.move(poses * math.nan), "for number 0 of environment 0"),
        (lambda b: b.move(poses, [True]), "a mask of shape (2,)"),
    ]


@pytest.mark.parametrize("index", range(len(wrong_calls())))
def test_wrong_calls_change_nothing(world_of, index):
    call, message = wrong_calls()[index]
    with SimulationBatch(world_of(models=TEAM), 2, robots=ROBOTS) as batch:
        before = batch.step(np.ones((2, 3, 2)))
        with pytest.raises(UsageError) as error:
            call(batch)
        assert message in str(error.value)
        for array, kept in zip(batch.observe(), before):
            assert np.array_equal(array, kept)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"robots": "robot"}, UsageError, "expected robots as a list, found 'robot'"),
        ({"robots": []}, UsageError, "different names, one at least, found []"),
        ({"robots": ["robot", "robot"]}, UsageError, "different names"),
        ({"robots": ["robot"], "robot": "robot"}, UsageError, "robot or robots, found both"),
        ({"robots": ["robot", "box1"]}, ModelError, '"box1" has: none'),
        ({"robots": ["robot", "third"], "moved": ["third"]}, UsageError, 'the robot "third"'),
        ({"robots": ["robot", "nobody"]}, ModelError, 'no model "nobody"'),
    ],
)
def test_robots_that_cannot_be_used(world_of, arguments, error, message):
    with pytest.raises(error) as found:
        SimulationBatch(world_of(models=TEAM), 2, **arguments)
    assert message in str(found.value)


def test_robots_that_differ_are_refused(world_of):
    world = world_of(models=TEAM)
    other = (world.parent / "robot.yaml").read_text().replace("range: 6", "range: 5")
    (world.parent / "other.yaml").write_text(other)
    text = world.read_text()
    world.write_text(text.replace("second, model: robot.yaml", "second, model: other.yaml"))
    with pytest.raises(UsageError, match=r"alike: range of robot: 6\.0, of second: 5\.0"):
        SimulationBatch(world, 2, robots=["robot", "second"])


def test_free_poses_may_be_where_robots_of_the_batch_stand(world_of):
    world = world_of(models=TEAM)
    place = [[-1.5, 1.0]]  # of the robot "second"
    with SimulationBatch(world, 1, robot="robot") as batch:
        assert not batch.free_space(0.3).contains(np.array(place)).any()
    with SimulationBatch(world, 1, robots=ROBOTS) as batch:
        assert batch.free_space(0.3).contains(np.array(place)).all()

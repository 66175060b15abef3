"""SimulationBatch: each environment has the bits of a Simulation of the same seed."""

import math
from pathlib import Path

import numpy as np
import pytest

from flatland_server import (
    BatchObservation,
    ModelError,
    ModelPlugin,
    PluginError,
    PluginLoader,
    Simulation,
    SimulationBatch,
    UsageError,
)
from flatland_server.testing import WorldFiles

OFFICE = "office"
LASER = """{type: Laser, name: laser, body: base, range: 6, origin: [0.1, 0.02, 0.1],
 angle: {min: -2, max: 2, increment: 0.05}, noise_std_dev: NOISE}"""
DRIVES = {
    "DiffDrive": """{type: DiffDrive, name: drive, body: base, odom_drift: [.1, .1, .1],
 linear_dynamics: {acceleration_limit: 2, velocity_limit: 1.5}}""",
    "OmniDrive": "{type: OmniDrive, name: drive, body: base}",
    "TricycleDrive": """{type: TricycleDrive, name: drive, body: base, max_steer_angle: 0.7,
 front_wheel_joint: front, rear_left_wheel_joint: left, rear_right_wheel_joint: right}""",
}
ROBOT = """
bodies:
  - {name: base, pose: [0.05, 0, 0.2],
     footprints: [{type: circle, radius: 0.25, center: [-0.1, 0], density: 5, friction: 0.4}]}
  - {name: front, pose: [0.05, 0, 0.2], footprints: [WHEEL]}
  - {name: left, pose: [-0.25, 0.1, 0.2], footprints: [WHEEL]}
  - {name: right, pose: [-0.2, -0.2, 0.2], footprints: [WHEEL]}
joints:
  - {type: revolute, name: front, bodies: [{name: base, anchor: [0, 0]},
     {name: front, anchor: [0, 0]}]}
  - {type: weld, name: left, bodies: [{name: base, anchor: [-0.3, 0.15]},
     {name: left, anchor: [0, 0]}]}
  - {type: weld, name: right, bodies: [{name: base, anchor: [-0.3, -0.15]},
     {name: right, anchor: [0, 0]}]}
plugins:
  - DRIVE
  - LASER
  - {type: Bumper, name: bumper}
  - {type: ModelTfPublisher, name: tf}
""".replace("WHEEL", "{type: circle, radius: 0.05, density: 1, layers: []}")
BOX = """
bodies:
  - name: base
    footprints: [{type: polygon, points: [[-.2, -.2], [.2, -.2], [.2, .2], [-.2, .2]], density: 3,
      friction: 0.6, restitution: 0.2}]
    linear_damping: 1
"""
DOOR = """
bodies:
  - {name: door, type: kinematic,
     footprints: [{type: polygon, points: [[-.6, -.1], [.6, -.1], [.6, .1], [-.6, .1]],
       density: 1}]}
plugins: [{type: Tween, name: tween, body: door, delta: [0.5, 1, 1], duration: 1.3}]
"""
WALLS = ("-3 -3 3 -3", "3 -3 3 3", "3 3 -3 3", "-3 3 -3 -3", "-1 2 1 2", "1 1 1 2", "1 1 2.5 1")
WORLD = """
properties: {}
layers: [{name: map, map: MAP}]
models:
  - {name: box1, model: box.yaml, pose: [1, -1, 0.3]}
  - {name: robot, model: robot.yaml, pose: [-1, 0, 0]}
  - {name: box2, model: box.yaml, pose: [0, 0.1, 0]}
  - {name: box3, model: box.yaml, pose: [0, -0.35, 0]}
  - {name: door, model: door.yaml, pose: [0, -2, 0]}
"""
SUBSTEPS = 20
ROUNDS = 40
RESET_AT = 25


@pytest.fixture(scope="module")
def world_of(tmp_path_factory):
    """Writes the world with a drive and noise of the lidar; returns its file."""

    def write(drive="DiffDrive", noise="0", models=WORLD, others="") -> Path:
        files = WorldFiles(tmp_path_factory.mktemp("world"))
        files.write(
            "robot.yaml",
            ROBOT.replace("DRIVE", DRIVES[drive] + others).replace(
                "LASER", LASER.replace("NOISE", noise)
            ),
        )
        files.write("box.yaml", BOX)
        files.write("door.yaml", DOOR)
        return files.write("world.yaml", models.replace("MAP", files.walls("map", *WALLS)))

    return write


def commands(k, size):
    """What the robot of environment k is commanded in each round, shape (ROUNDS, size)."""
    rng = np.random.default_rng(k)
    return rng.uniform([-0.5, -1.5, -1.5][:size], [2.0, 1.5, 1.5][:size], (ROUNDS, size))


def start(k):
    """Where the robot of environment k is put when it is reset: each is at another place."""
    return np.array([-2 + 0.01 * k, -1.0 + 0.02 * k, 0.3 * k])


def run_simulation(world, k, size):
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
            for _ in range(SUBSTEPS):
                simulation.step()
                collided |= any(touch_of_robot(each) for each in simulation.contacts)
            rows.append(
                (
                    robot.sensors["laser"].read(),
                    simulation.poses[index],
                    simulation.velocities[index],
                    np.array(robot.local_velocity),
                    collided,
                    simulation.time,
                )
            )
    return [np.array([row[field] for row in rows]) for field in range(6)]


def touch_of_robot(touch):
    models = (touch.model_a, touch.model_b)
    return "robot" in models and models != ("robot", "robot") and len(touch.points) > 0


def run_batch(world, count, threads, size):
    """The observations of a batch: arrays with a row for each round and environment."""
    observations = []
    is_even = np.arange(count) % 2 == 0
    with SimulationBatch(world, count, threads=threads, seed=100) as batch:
        actions = np.stack([commands(k, size) for k in range(count)], axis=1)
        for i in range(ROUNDS):
            if i == RESET_AT:
                poses = np.stack([start(k) for k in range(count)])
                batch.reset(is_even, seeds=np.arange(500, 500 + count), poses=poses)
            observations.append(batch.step(actions[i], SUBSTEPS))
    return [np.stack([each[field] for each in observations]) for field in range(6)]


@pytest.fixture(scope="module")
def noisy(world_of):
    """A world with noise, and what Simulations of environments 0, 1, 6 and 63 give there."""
    world = world_of(noise="0.02")
    return world, {k: run_simulation(world, k, 2) for k in (0, 1, 6, 63)}


@pytest.mark.parametrize("threads", [1, 2, 4])
@pytest.mark.parametrize("count", [1, 7, 64])
def test_an_environment_is_a_simulation_whatever_its_neighbours(noisy, count, threads):
    world, expected = noisy

    found = run_batch(world, count, threads, 2)

    for k in [each for each in expected if each < count]:
        for name, array, reference in zip(BatchObservation._fields, found, expected[k]):
            assert np.array_equal(array[:, k], reference), (k, name)
    if count > 1:
        assert found[4].any()
        assert not found[4].all()


@pytest.mark.parametrize(("drive", "size"), [("OmniDrive", 3), ("TricycleDrive", 2)])
def test_every_drive_is_that_of_a_simulation(world_of, drive, size):
    world = world_of(drive)

    found = run_batch(world, 3, 1, size)

    for k in range(3):
        for array, reference in zip(found, run_simulation(world, k, size)):
            assert np.array_equal(array[:, k], reference)


CROWD = """
plugins:
  - {type: Crowd, name: people, update_rate: 13, speed: 0.7, layers: [map], pedestrians: [
      {pose: [2, 0, 0], goals: [[-2, 0], [2, 0.5]], legs: true},
      {pose: [-2, -2.5, 0], goals: [[-2, 2.5], [-2.2, -2.5]], radius: 0.2},
      {pose: [2, -2, 2], goals: [[2.2, -2.2]], legs: true}]}
  - {type: Crowd, name: others, force: {noise: 0.2}, pedestrians: [
      {pose: [-2.5, 2.5, 0], goals: [[2.5, 2.5]]}]}
"""


@pytest.mark.parametrize("count", [1, 7])
def test_a_crowd_is_that_of_a_simulation(world_of, monkeypatch, count):
    """Updates of 13 Hz are due within calls of step, in each environment at other times."""
    monkeypatch.setitem(globals(), "SUBSTEPS", 7)
    world = world_of(noise="0.02", models=WORLD + CROWD)
    expected = {k: run_simulation(world, k, 2) for k in {0, count // 2, count - 1}}

    for threads in (1, 2, 4):
        found = run_batch(world, count, threads, 2)
        for k, references in expected.items():
            for name, array, reference in zip(BatchObservation._fields, found, references):
                assert np.array_equal(array[:, k], reference), (k, name)


MORE_WALLS = """
  - {type: RandomWall, name: more, layer: map, num_of_walls: 2, wall_wall_dist: 0.4,
     robot_name: robot}
"""


def test_walls_that_differ_are_those_of_simulations(world_of):
    world = world_of(models=WORLD + CROWD + MORE_WALLS)
    expected = {k: run_simulation(world, k, 2) for k in range(3)}

    for threads in (1, 2):
        found = run_batch(world, 3, threads, 2)
        for k, references in expected.items():
            for name, array, reference in zip(BatchObservation._fields, found, references):
                assert np.array_equal(array[:, k], reference), (k, name)
    with SimulationBatch(world, 2, seed=7) as batch:
        walls = [batch.added_walls(k) for k in range(2)]
        assert [each.shape for each in walls] == [(2, 4)] * 2
        assert not np.array_equal(*walls)
        view = batch.view(1)
        assert np.array_equal(view.world.layers[0].segments[-2:], walls[1])
        first = batch.observe()
        batch.reset(seeds=8)
        assert np.array_equal(batch.added_walls(0), walls[1])
        assert np.array_equal(batch.observe().ranges[0], first.ranges[1])


def test_where_people_are_is_seen_in_a_view(world_of):
    world = world_of(models=WORLD + CROWD)
    with SimulationBatch(world, 2, seed=7) as batch, Simulation(world, seed=8) as simulation:
        batch.step(np.zeros((2, 2)), 300)
        simulation.step(300)
        people = simulation.models["people_0"].model
        shown = batch.view(1).models["people_0"].model
        assert [body.pose for body in shown.bodies.values()] == [
            body.pose for body in people.bodies.values()
        ]
        assert math.dist(people.pose[:2], (2, 0)) > 0.5


def test_an_office_is_that_of_a_simulation():
    actions = np.random.default_rng(3).uniform([0.5, -1], [2.5, 1], (30, 2, 2))
    with SimulationBatch(OFFICE, 2) as batch, Simulation(OFFICE) as simulation:
        robot = simulation.models["turtlebot"]
        for action in actions:
            observation = batch.step(action)
            robot.command(*action[1])
            simulation.step(20)
            assert np.array_equal(observation.poses[1], simulation.poses[0])
            assert np.array_equal(observation.ranges[1], robot.sensors["laser"].read())


def test_scans_with_the_walls_of_a_cell_are_those_with_all(world_of):
    # So many scans from one place that the core has looked up which walls are seen from there.
    with SimulationBatch(OFFICE, 1) as batch:
        first = batch.observe().ranges
        for _ in range(600):
            last = batch.observe().ranges

    assert np.array_equal(first, last)


def test_a_view_shows_an_environment(world_of):
    actions = commands(5, 2)[:, None] * np.ones((3, 1))
    with SimulationBatch(world_of(noise="0.02"), 3, seed=7) as batch:
        for action in actions[:5]:
            observation = batch.step(action, SUBSTEPS)
        for k in (0, 2, 1):
            view = batch.view(k)
            index = list(view.models).index("robot")
            robot = view.models["robot"]
            assert np.array_equal(view.poses[index], observation.poses[k])
            assert np.array_equal(robot.sensors["laser"].read(), observation.ranges[k])
            assert view.time == observation.times[k]
        with Simulation(world_of(noise="0.02"), seed=8) as simulation:
            for action in actions[:5, 1]:
                simulation.models["robot"].command(*action)
                simulation.step(SUBSTEPS)
            assert np.array_equal(view.poses, simulation.poses)
            assert np.array_equal(view.render(sensors=True), simulation.render(sensors=True))


def test_facts_of_the_robot(world_of):
    with SimulationBatch(world_of("TricycleDrive"), 3, threads=2, seed=[5, 3, 9]) as batch:
        assert (batch.num_envs, batch.threads, batch.robot) == (3, 2, "robot")
        assert batch.action_names == ("speed", "steer_angle")
        assert batch.action_limits.tolist() == [[-math.inf, -0.7], [math.inf, 0.7]]
        assert (batch.beams, batch.max_range, batch.step_size) == (81, 6.0, 0.005)
        assert batch.seeds.tolist() == [5, 3, 9]


def test_arrays_of_an_observation_are_new_or_those_that_are_passed(world_of):
    with SimulationBatch(world_of(), 4) as batch:
        actions = np.full((4, 2), 0.5, np.float32)
        first = batch.step(actions)
        before = first.copy()
        out = BatchObservation.empty(4, batch.beams)

        assert batch.step(actions, out=out) is out

        for array, kept in zip(first, before):
            assert np.array_equal(array, kept)
        assert not np.array_equal(out.poses, first.poses)
        assert out.times.tolist() == [0.2] * 4


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
        (lambda b: b.step(ones * [1, math.nan]), "found [1.0, nan] for environment 0"),
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
        (lambda b: b.view(2), "expected an environment from 0 to 1, found 2"),
        (lambda b: b.view("1"), "found '1'"),
        (lambda b: b.free_poses(1, 0.0, np.random.default_rng(0)), "clearance"),
        (lambda b: b.free_space(None), "expected a clearance above zero, found None"),
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
    is_passive = True

    def on_initialize(self, config):
        pass

    def before_physics_step(self, timekeeper):
        pass


class Actor(Observer):
    def after_physics_step(self, timekeeper):
        pass


class Loader(PluginLoader):
    def load(self, type, base):
        return {"Actor": Actor, "Observer": Observer}.get(type) or super().load(type, base)


def test_plugins_that_act_by_themselves_are_refused_by_name(world_of):
    """A class that overrides a hook has to say again that it is passive."""
    batch = SimulationBatch(
        world_of(others="\n  - {type: Observer, name: eye}"), 1, loader=Loader()
    )
    batch.close()
    with pytest.raises(PluginError, match=r'"robot/hand" \(Actor\) acts in Python'):
        SimulationBatch(world_of(others="\n  - {type: Actor, name: hand}"), 1, loader=Loader())


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

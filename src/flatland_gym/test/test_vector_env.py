"""The vector environment, compared bit for bit with SyncVectorEnv of single ones."""

import copy

import gymnasium as gym
import numpy as np
import pytest
from environments import ID, assert_same, make, make_vector
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from flatland2d import DistanceGrid, UsageError, world_content
from flatland_gym import SCENARIOS
from flatland_gym.fleet import BatchFleet, SimulationFleet
from flatland_gym.navigation_world import NavigationWorld
from flatland_server.plugins import shared_loader

pytestmark = pytest.mark.slow

CROWDED = {"time_limit": 2.0, "goal_distance": (0.4, 1.2), "beams": 16}
"""Episodes end often: by success, by collision and by the time limit."""


@pytest.fixture
def files_read_once(monkeypatch):
    """Environments of equal worlds share one `NavigationWorld`: loading takes most of the time."""
    load, loaded = NavigationWorld.load, {}

    def load_once(*arguments):
        key = repr(arguments)
        if key not in loaded:
            loaded[key] = load(*arguments)
        return loaded[key]

    monkeypatch.setattr(NavigationWorld, "load", load_once)


def drive(env, mode, steps, seed=11):
    """All results of an environment in a run with resets; and its number of ends of each kind."""
    rng = np.random.default_rng(5)
    results = [env.reset(seed=seed)]
    ends = np.zeros(3, int)
    for step in range(steps):
        actions = rng.uniform(-1.5, 2.0, env.action_space.shape).astype(np.float32)
        actions[:, 0] = np.abs(actions[:, 0])
        if isinstance(results[-1][0], np.ndarray):  # every other robot heads for its goal
            actions[::2, 1] = 2 * results[-1][0][::2, 16 + 2]
        result = env.step(actions)
        results.append(result)
        infos = result[4].get("final_info", result[4])
        ends += (infos["success"].sum(), result[2].sum(), result[3].sum())
        if mode == "Disabled":
            ended = result[2] | result[3]
            if ended.any():
                results.append(env.reset(options={"reset_mask": ended}))
        if step == steps // 2:
            results.append(env.reset(options={}))
    env.close()
    return results, ends


def fleets(env):
    """The kinds of fleets that an environment has used."""
    return {type(fleet) for fleet in env.unwrapped.navigation._fleets.values()}


def with_a_person_and_walls(count=2):
    """A room in which a person walks, and walls are added that differ from episode to episode."""
    room = world_content(SCENARIOS["empty_room"].world)
    person = {"pose": [-3, 2, 0], "goals": [[3, 2], [-3, -2]]}
    walls = {"layer": "walls", "robot_name": "robot", "num_of_walls": count, "wall_wall_dist": 0.6}
    room["plugins"] = [
        {"type": "Crowd", "name": "person", "update_rate": 20, "pedestrians": [person]},
        {"type": "RandomWall", "name": "more", **walls},
    ]
    return room


def with_a_cart():
    """A room in which a plugin moves a cart, in Python at each step."""
    room = world_content(SCENARIOS["empty_room"].world)
    disc = {"type": "circle", "radius": 0.2, "density": 1}
    body = {"name": "base", "type": "kinematic", "footprints": [disc]}
    plugin = {"type": "ConstVelocity", "name": "moves", "body": "base"}
    plugin.update(vel_x=0.1, vel_y=0.0, omega=0.0)
    model = {"bodies": [body], "plugins": [plugin]}
    room["models"].append({"name": "cart", "pose": [-4, 0, 0], "model": model})
    return room


@pytest.mark.usefixtures("files_read_once")
@pytest.mark.parametrize("mode", [mode.value for mode in AutoresetMode])
@pytest.mark.parametrize("count", [1, 7])
@pytest.mark.parametrize(
    "world", ["discs", ("discs", with_a_person_and_walls())], ids=["one world", "two worlds"]
)
def test_a_vector_environment_equals_single_ones(mode, count, world):
    arguments = {"world": world, **CROWDED}
    single = SyncVectorEnv([lambda: make(**arguments)] * count, autoreset_mode=mode)
    expected, ends = drive(single, mode, 80)

    for threads in (1, 4)[:count]:  # four threads do not share seven environments equally
        vector = make_vector(count, threads=threads, autoreset_mode=mode, **arguments)
        found, _ = drive(vector.unwrapped, mode, 80)
        assert_same(expected, found)
        assert fleets(vector) == {BatchFleet}

    if count == 7:
        assert (ends > 0).all()  # there was each kind of end


@pytest.mark.parametrize("kind", [np.float16, np.float64, np.longdouble, np.int8, np.uint64, list])
def test_actions_may_be_of_any_type_of_numbers(kind):
    single, vector = make(world="empty_room", beams=4), make_vector(1, world="empty_room", beams=4)
    single.reset(seed=3), vector.reset(seed=3)
    for values in ([1, 0], [0.3, 0.7], [1, 100], [0, 3]):
        action = values if kind is list else np.array(values, kind)
        found = single.step(action)
        expected = vector.step([action] if kind is list else action[None])
        assert_same(found[0], expected[0][0])
        assert type(found[1]) is float
        assert found[1] == expected[1][0]


@pytest.mark.parametrize(
    "arguments",
    [
        {"world": "corridor", "frame_skip": 2, "step_size": 0.025},  # with a crowd
        {"world": "doors", "flatten": False, "lidar_noise": 0.02},
        {"world": "office", "frame_skip": 3, "step_size": 0.01},
        {"world": "empty_room", "obstacles": (0, 6), "lidar_noise": 0.01},
        {"world": ("empty_room", "doors"), "obstacles": (0, 4), "robot_scales": (0.8, 1.2)},
        {
            "reward": lambda step: step.previous_distance - step.distance + step.actions[:, 1],
            "terminated": lambda step: step.success | (step.ranges.min(axis=1) < 0.3),
        },
        {
            "rewards": {"progress": np.float32(0.1), "collision": -3},
            "goal_radius": np.float32(0.3),
            "step_size": np.float32(0.05),
            "collision_ends": np.bool_(False),
        },
    ],
    ids=lambda arguments: ", ".join(arguments),
)
def test_it_equals_single_environments_with_any_random_source(arguments):
    arguments = {"world": "discs", **CROWDED, **arguments}
    single = SyncVectorEnv([lambda: make(**arguments)] * 3, autoreset_mode="SameStep")
    vector = make_vector(3, autoreset_mode="SameStep", threads=2, **arguments)

    assert_same(drive(single, "SameStep", 60)[0], drive(vector, "SameStep", 60)[0])


@pytest.mark.parametrize(
    ("world", "kinds"),
    [
        (with_a_cart(), {SimulationFleet}),
        (("empty_room", with_a_cart()), {BatchFleet, SimulationFleet}),
    ],
    ids=["alone", "beside a batch"],
)
def test_a_plugin_that_acts_at_steps_has_simulations(world, kinds):
    arguments = {**CROWDED, "world": world, "time_limit": 0.5}
    single = SyncVectorEnv([lambda: make(**arguments)] * 3, autoreset_mode="SameStep")
    vector = make_vector(3, threads=2, autoreset_mode="SameStep", **arguments)
    assert_same(drive(single, "SameStep", 25)[0], drive(vector.unwrapped, "SameStep", 25)[0])
    assert fleets(vector) == kinds


CRAB = """
from flatland_server import BatchRole, CoreDrive, ModelPlugin

class Crab(ModelPlugin):
    def on_initialize(self, config):
        body = self.get_body(config)
        config.finish()
        self._drive = body.physics_body.add_drive((0.0, 0.0, 0.7))

    @property
    def batch_role(self):
        return BatchRole(drive=CoreDrive(self._drive, (1, 2), (0.7, 0.0)))

    def command(self, sideways, yaw_rate):
        self._drive.command(0.0, sideways, yaw_rate)
"""
ENTRY_POINT = "[flatland_server.plugins]\nCrab = crab_of_a_user:Crab\n"


@pytest.fixture
def crab(tmp_path, monkeypatch):
    """A package of a user, installed as pip does it."""
    monkeypatch.syspath_prepend(str(tmp_path))
    info = tmp_path / "crab-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: crab\n")
    (info / "entry_points.txt").write_text(ENTRY_POINT)
    (tmp_path / "crab_of_a_user.py").write_text(CRAB)
    shared_loader.cache_clear()  # looked up once in a process
    yield
    shared_loader.cache_clear()


@pytest.mark.usefixtures("crab")
def test_a_drive_of_a_user_is_trained_as_it_is_driven_in_a_batch():
    """It goes sideways, and has no limit for turning."""
    room = world_content(SCENARIOS["empty_room"].world)
    robot = room["models"][0]["model"]
    [drive_of_room] = [each for each in robot["plugins"] if each["type"] == "DiffDrive"]
    crab = {"type": "Crab", "name": "legs", "body": drive_of_room["body"]}
    robot["plugins"][robot["plugins"].index(drive_of_room)] = crab
    arguments = {**CROWDED, "world": room, "time_limit": 0.5}

    single = SyncVectorEnv([lambda: make(**arguments)] * 2, autoreset_mode="SameStep")
    vector = make_vector(2, autoreset_mode="SameStep", **arguments).unwrapped

    assert vector.single_action_space.high == pytest.approx([0.7, 2.0])
    vector.reset(seed=1, options={"start": [0, 0, 0], "goal": [2, 0]})
    pose = vector.step(np.array([[0.7, 0.0]] * 2))[4]["pose"][0]
    assert (pose[0], pose[1] > 0.0) == (pytest.approx(0.0, abs=1e-6), True)
    assert_same(drive(single, "SameStep", 15)[0], drive(vector, "SameStep", 15)[0])
    assert fleets(vector) == {BatchFleet}


def test_a_batch_is_made_when_an_episode_is_in_its_world():
    env = make_vector(3, world=("discs", "doors", "empty_room"), beams=4)
    made = env.unwrapped.navigation._fleets
    env.reset(seed=1, options={"world": "empty_room"})
    assert list(made) == [2]
    last = np.array([False, False, True])
    env.reset(options={"reset_mask": last, "world": "discs"})
    assert list(made) == [2, 0]


def test_starts_and_goals_are_clear_of_walls_added_by_plugins():
    env = make(world=with_a_person_and_walls(), goal_distance=(0.4, 3.0), beams=32, flatten=False)
    for seed in range(60):
        observation, info = env.reset(seed=seed)
        walls = env.navigation.simulation(0).world.layers[0].segments
        assert len(walls) == 4 + 2
        assert observation["ranges"].min() * 10 > 0.2 + 0.09  # radius and margin
        assert DistanceGrid(walls, (0.0, 0.0), 1.0).distance(*info["goal"]) > 0.2
    env = make(world=with_a_person_and_walls(4), beams=32)
    with pytest.raises(UsageError, match="walls that a plugin of the world has added"):
        env.reset(seed=1, options={"goal": [4.4, 0.0]})


@pytest.mark.parametrize(
    ("world", "count"), [("discs", 64), ("corridor", 128), ("empty_room", 1024)]
)
def test_an_environment_is_the_same_among_others(world, count):
    few, many = make_vector(2, world=world, **CROWDED), make_vector(count, world=world, **CROWDED)
    a, b = few.reset(seed=3), many.reset(seed=3)
    for _ in range(50):
        actions = np.tile(np.float32([0.6, 0.3]), (count, 1))
        assert_same(a[0], b[0][:2])
        a, b = few.step(actions[:2]), many.step(actions)


def test_results_are_not_written_to_again():
    env = make_vector(3, world="empty_room", autoreset_mode="SameStep", **CROWDED)
    env.reset(seed=1)
    kept, copies = [], []
    for _ in range(60):
        kept.append(env.step(np.tile(np.float32([0.8, 0.0]), (3, 1))))
        copies.append(copy.deepcopy(kept[-1]))

    assert any("final_obs" in result[-1] for result in kept)
    assert_same(kept, copies)


def test_the_last_observation_of_an_episode_is_that_of_its_end():
    """The robot that has collided is where it collided, not at its next start."""
    env = make_vector(1, world="empty_room", autoreset_mode="SameStep", goal_distance=(4, 5))
    env.reset(seed=2, options={"start": [3, 0, 0], "goal": [-1, 0]})
    infos = {}
    while "final_info" not in infos:
        *_, infos = env.step(np.float32([[0.8, 0.0]]))

    assert infos["final_info"]["collision"][0]
    assert infos["final_info"]["pose"][0, 0] == pytest.approx(4.8, abs=0.02)  # 5 m less the radius
    assert infos["final_obs"][0][:64].min() == pytest.approx(0.02, abs=0.002)  # 0.2 m of 10 m
    assert infos["pose"][0, 0] < 4.7


@pytest.mark.parametrize("mode", [mode.value for mode in AutoresetMode])
def test_a_number_of_steps_truncates_as_in_single_environments(mode):
    arguments = {"world": "empty_room", **CROWDED, "max_episode_steps": 25}
    spec = gym.make(ID, **arguments).spec  # it has the number, and gives it to make_vec
    single = SyncVectorEnv([lambda: gym.make(spec)] * 3, autoreset_mode=mode)
    expected, ends = drive(single, mode, 60)

    found, _ = drive(gym.make_vec(spec, num_envs=3, autoreset_mode=mode), mode, 60)

    assert_same(expected, found)
    assert ends[2] > 0


@pytest.mark.parametrize(
    "arguments",
    [
        {"world": "office", "lidar_noise": 0.05},
        {"world": "discs", "obstacles": 3},
        {"world": "doors"},
        {"world": "corridor"},
        {"world": ("empty_room", "doors")},
    ],
    ids=["boxes and noise", "obstacles", "a door", "a crowd", "two worlds"],
)
def test_pictures_are_those_of_single_environments(arguments):
    """To the pixel, after a reset of one of two environments."""
    arguments = {**arguments, "goal_distance": (1, 3), "render_mode": "rgb_array"}
    arguments["terminated"] = lambda step: np.zeros(len(step.distance), bool)
    single = SyncVectorEnv([lambda: make(**arguments)] * 2, autoreset_mode="Disabled")
    vector = make_vector(2, autoreset_mode="Disabled", **arguments)
    frames = []
    for env in (single, vector):
        env.reset(seed=1)
        for step in range(40):
            env.step(np.float32([[0.5, 0.4], [0.2, -0.1]]))
            if step == 20:
                env.reset(options={"reset_mask": np.array([False, True])})
        frames.append(env.render())

    assert isinstance(frames[1], tuple)
    assert_same(frames[0], frames[1])
    assert not np.array_equal(*frames[1])


def test_render_envs_limits_the_number_of_pictures():
    env = make_vector(5, world="empty_room", beams=4, render_mode="rgb_array", render_envs=2)
    env.reset(seed=1)
    frames = env.render()

    assert [(frame.shape, frame.dtype) for frame in frames] == [((480, 480, 3), np.uint8)] * 5
    assert [bool(frame.any()) for frame in frames] == [True, True, False, False, False]


def test_wrappers_of_gymnasium_work():
    env = gym.wrappers.vector.RecordEpisodeStatistics(make_vector(4, world="discs", **CROWDED))
    env.reset(seed=1)
    lengths = []
    for _ in range(60):
        *_, infos = env.step(env.action_space.sample())
        if "episode" in infos:
            lengths += infos["episode"]["l"][infos["_episode"]].tolist()
    assert lengths
    assert max(lengths) <= 40

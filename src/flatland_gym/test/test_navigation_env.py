"""The single environment: Gymnasium's checks, rewards, ends, pictures, and wrong calls."""

import importlib.util
import io
import math
import sys
import urllib.request
import warnings

import gymnasium as gym
import numpy as np
import pytest
from environments import ID, assert_same, make, make_vector
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env
from PIL import Image

import flatland_gym
from flatland2d import FlatlandError, MissingPackageError, UsageError, world_content
from flatland_gym import RewardWeights

pytestmark = pytest.mark.slow

FORWARDS = np.float32([0.8, 0.0])


@pytest.mark.parametrize(
    "arguments",
    [{"world": "discs"}, {"world": "office", "beams": 36, "flatten": False}],
    ids=["discs", "office, dicts"],
)
def test_it_passes_gymnasiums_check(arguments, without_screen):
    with warnings.catch_warnings():
        warnings.filterwarnings("error")
        # The actions have units: a policy drives a robot as it is. RescaleAction takes them away.
        warnings.filterwarnings("ignore", message=".*symmetric and normalized space.*")
        env = make(**arguments)
        check_env(env)


def test_the_registered_environment_has_gymnasiums_wrappers():
    env = gym.make(ID, world="empty_room")
    observation, _ = env.reset(seed=1)
    assert env.observation_space.contains(observation)
    assert observation.shape == (64 + 3 + 2,)
    most = np.float32([0.8, 2])
    assert env.action_space == gym.spaces.Box(-most, most, dtype=np.float32)


def test_the_observation_is_what_the_documentation_says():
    env = make(world="empty_room", flatten=False)
    observation, info = env.reset(seed=1, options={"start": [1, 2, math.pi / 2], "goal": [-2, 2]})
    assert info["distance"] == 3.0
    assert observation["goal"] == pytest.approx([0.3, 0.0, 1.0], abs=1e-6)  # to the left
    assert observation["ranges"][32] == pytest.approx(0.3, abs=1e-6)  # ahead: 3 m of 10 m
    assert observation["velocity"].tolist() == [0, 0]
    for _ in range(20):
        observation, *_ = env.step([0.4, 0.0])
    assert observation["velocity"] == pytest.approx([0.5, 0.0], abs=1e-6)  # of 0.8 m/s


def test_a_beam_without_a_return_is_observed_as_1(tmp_path):
    content = world_content(flatland_gym.SCENARIOS["empty_room"].world)
    content["layers"] = []
    env = make(world=content)
    observation, _ = env.reset(seed=1)
    assert (observation[:64] == 1).all()


def test_the_goal_is_reached():
    env = make(world="empty_room", rewards=RewardWeights(2.0, 5.0, -3.0, -1.0))
    env.reset(seed=1, options={"start": [0, 0, 0], "goal": [1, 0]})
    terminated, total, steps = False, 0.0, 0
    while not terminated:
        _, reward, terminated, truncated, info = env.step(FORWARDS)
        assert not truncated
        total, steps = total + reward, steps + 1
    assert info["success"]
    assert not info["collision"]
    assert info["distance"] < 0.3
    assert total == pytest.approx(2 * (1 - info["distance"]) + 5 - steps * 0.05)


def test_a_collision_ends_the_episode_or_not():
    for ends in (True, False):
        env = make(world="empty_room", collision_ends=ends)
        env.reset(seed=1, options={"start": [4, 0, 0], "goal": [-1, 0]})
        results = [env.step(FORWARDS) for _ in range(40)]
        hits = [result for result in results if result[4]["collision"]]
        assert hits
        assert hits[0][1] < -9
        assert hits[0][2] == ends


def test_the_time_limit_truncates():
    env = make(world="empty_room", time_limit=1.0)
    env.reset(seed=1)
    results = [env.step([0.0, 0.0]) for _ in range(20)]
    assert [result[3] for result in results] == [False] * 19 + [True]


def test_reward_and_termination_can_be_replaced():
    def reward(step):
        return -np.abs(step.velocities[:, 2])

    def terminated(step):
        return step.distance > 2.0

    env = make(world="empty_room", reward=reward, terminated=terminated)
    env.reset(seed=1, options={"start": [0, 0, 0], "goal": [1.9, 0]})
    _, first, ended, _, _ = env.step([-0.8, 1.0])
    assert first == pytest.approx(-0.3)  # by 6 rad/s^2 in 50 ms
    assert not ended
    results = [env.step([-0.8, 0.0]) for _ in range(10)]
    assert results[-1][2]

    for wrong, message in (
        (lambda step: 1.0, r"expected reward to return shape \(1,\), found \(\)"),
        (lambda step: np.nan * step.distance, "expected reward to return finite .*, found .*nan"),
    ):
        env = make(world="empty_room", reward=wrong)
        with pytest.raises(UsageError, match="expected reset before step"):
            env.step(FORWARDS)
        env.reset(seed=1)
        with pytest.raises(UsageError, match=message):
            env.step(FORWARDS)


def test_an_environment_can_be_made_from_its_spec_in_json():
    spec = gym.make(ID, world="empty_room", rewards={"time": -7.0}, time_limit=math.inf).spec
    env = gym.make(EnvSpec.from_json(spec.to_json())).unwrapped
    observation, _ = env.reset(seed=np.int64(3))
    assert_same(observation, env.reset(seed=3)[0])
    assert env.step(np.zeros(2))[1] == pytest.approx(-0.35)


def test_frames_are_skipped():
    slow, quick = (make(world="empty_room", step_size=0.01, frame_skip=skip) for skip in (1, 5))
    slow.reset(seed=1), quick.reset(seed=1)
    for _ in range(10):
        for _ in range(5):
            a = slow.step(FORWARDS)
        b = quick.step(FORWARDS)
        assert_same(a[0], b[0])


@pytest.mark.parametrize("world", ["empty_room", "discs", "corridor", "doors", "office"])
def test_nothing_is_touched_at_the_start(world):
    env = make(world=world, obstacles=3)
    for seed in range(20):
        _, info = env.reset(seed=seed)
        simulation = env.navigation.simulation(0)
        robot = env.navigation.robot.name
        assert simulation.models[robot].model.overlapping() == []
        assert 1.0 <= info["distance"] <= 10.0
        *_, info = env.step([0.0, 0.0])
        assert not info["collision"]


def test_scattered_models_and_obstacles_are_elsewhere_each_time():
    env = make(world="discs", obstacles=(0, 5))
    places = []
    for seed in range(6):
        env.reset(seed=seed)
        places.append(env.navigation.simulation(0).poses[1:, :2])
    counts = [(place[12:] < 100).all(axis=1).sum() for place in places]
    assert len(set(counts)) > 1
    assert max(counts) <= 5
    assert all(not np.array_equal(a, b) for a, b in zip(places, places[1:]))
    inside = places[0][(places[0] < 100).all(axis=1)]
    gaps = np.linalg.norm(inside[:, None] - inside[None], axis=2)[np.triu_indices(len(inside), 1)]
    assert gaps.min() > 0.3 + 2 * 0.2  # there is a way through


def test_models_that_are_named_like_obstacles_stay():
    content = world_content(flatland_gym.SCENARIOS["empty_room"].world)
    column = {"name": "c", "type": "static", "footprints": [{"type": "circle", "radius": 0.3}]}
    column["footprints"][0]["density"] = 1
    model = {"name": "obstacle_2", "pose": [3, 3, 0], "model": {"bodies": [column]}}
    content["models"].append(model)
    env = make(world=content, obstacles=2)
    for _ in range(3):
        env.reset()
        models = env.navigation.simulation(0).models
        assert list(models) == ["robot", "obstacle_2", "obstacle_1", "obstacle_3"]
        assert models["obstacle_2"].pose == (3, 3, 0)


def test_an_option_chooses_the_world():
    env = make(world=("empty_room", "doors"))
    for name, models in (("doors", 2), ("empty_room", 1), ("doors", 2)):
        env.reset(options={"world": name})
        assert len(env.navigation.simulation(0).models) == models


def test_the_lidar_gets_another_number_of_beams():
    env = make(world="empty_room", beams=8, flatten=False)
    observation, _ = env.reset(options={"start": [0, 0, 0], "goal": [2, 0]})
    # Behind, behind right ... : eight beams, 45 degrees apart, in a square room.
    expected = [0.5, 0.5 * math.sqrt(2)] * 4
    assert observation["ranges"] == pytest.approx(expected, abs=1e-5)

    env = make(world="office", beams=3, flatten=False)
    assert env.reset(seed=1)[0]["ranges"].shape == (3,)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c["models"][0]["model"]["plugins"].pop(0), r"found robot \(no drive\)"),
        (lambda c: c["models"][0]["model"]["plugins"].pop(1), r"found robot \(no lidar\)"),
        (lambda c: c["models"].clear(), "a drive and a lidar, found none"),
        (
            lambda c: c["models"].append({**c["models"][0], "name": "other", "pose": [2, 2, 0]}),
            "expected one robot, found robot, other",
        ),
        (lambda c: c["models"][0].update(pose="here"), r"expected \[x, y, yaw\]"),
    ],
)
def test_a_world_that_cannot_be_used_is_named(change, message):
    content = world_content(flatland_gym.SCENARIOS["empty_room"].world)
    change(content)
    with pytest.raises(FlatlandError, match=message):
        make(world=content)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"world": "ofice"}, 'no world is named "ofice"'),
        ({"world": "test_room", "robot": "r2d2"}, 'no model "r2d2"; there are: turtlebot'),
        ({"world": "test_room", "lidar": "radar"}, 'no lidar "radar"; it has: laser'),
        ({"world": "discs", "scatter": ["box_*"]}, r"expected scatter to match models"),
        ({"world": ("discs", "office")}, "robots are alike: beams is 64 in discs, 1081 in office"),
        ({"step_size": 0}, "expected step_size to be a number above 0, found 0"),
        ({"time_limit": float("nan")}, "expected time_limit"),
        ({"frame_skip": 0.5}, "expected frame_skip to be a whole number above 0"),
        ({"goal_distance": 3}, r"expected goal_distance as a pair"),
        ({"goal_distance": (5, 1)}, "expected goal_distance to be two increasing lengths"),
        ({"goal_distance": ("a", 2)}, "expected goal_distance to be two increasing lengths"),
        ({"time_limit": 10**400}, "expected time_limit to be a number above 0, found 1000"),
        ({"obstacles": -1}, "expected obstacles to be"),
        ({"obstacles": 10**9}, "expected obstacles to be 0 to 10000"),
        ({"world": ()}, "expected world to be a world, or one at least"),
        ({"robot_scales": 1.2}, "expected robot_scales to be a sequence of numbers"),
        ({"scatter": "box_*"}, "expected scatter to be a sequence of patterns"),
        ({"flatten": "no"}, "expected flatten to be true or false"),
        ({"reward": "x"}, "expected reward to be a function of a Transition"),
        ({"rewards": {"sucess": 1}}, "expected rewards to be RewardWeights, or a dict of"),
        ({"rewards": {"success": "1"}}, "expected rewards.success to be a number, found '1'"),
        ({"params": [1]}, "expected params to be a dict by name"),
        ({"render_mode": "rgb"}, "expected render_mode"),
        (
            {"world": "crossing", "params": {"/poeple": 9}},
            r"""reads the parameter "/poeple" \(did you mean "/people"\?\); there are: /peo""",
        ),
        ({"world": ("discs", {"layers": 5})}, r"world\[1\]: world: layers: expected a list"),
        ({"world": ("discs", "office")}, r"world\[1\]: expected worlds in which the robots are a"),
        ({"colour": "red"}, "unexpected keyword argument 'colour'"),
    ],
)
def test_a_wrong_argument_is_named(arguments, message):
    with pytest.raises(FlatlandError, match=message):
        flatland_gym.NavigationEnv(**arguments)


@pytest.mark.parametrize("make_one", [make, lambda **arguments: make_vector(2, **arguments)])
def test_an_unknown_argument_is_a_type_error_as_of_any_function(make_one):
    # TorchRL's GymEnv tries `frameskip`, and looks for these words.
    with pytest.raises(TypeError, match="unexpected keyword argument 'frameskip'") as caught:
        make_one(frameskip=1)
    assert isinstance(caught.value, UsageError)


def test_a_parameter_may_be_that_of_one_of_several_worlds():
    make(world=("crossing", "circle_crossing"), params={"/people": 2, "/yields": 1}).close()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"goal_distance": (50.0, 60.0)}, "has no free start and goal 50 to 60 m apart"),
        ({"margin": 6.0}, r"has no room for a robot of 0\.2 m radius"),
    ],
)
def test_there_is_an_error_if_there_is_no_room(arguments, message):
    with pytest.raises(UsageError, match=message):
        make(world="empty_room", **arguments).reset(seed=1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda env: env.step([0.0, np.nan]), r"expected finite actions, found nan at \(1,\)"),
        (lambda env: env.step(np.zeros((1, 2))), r"expected actions of shape \(2,\)"),
        (lambda env: env.reset(seed=7, options={"goal": [5, 0]}), "expected a goal that is free"),
        (lambda env: env.reset(seed=7, options={"goal": [10**400, 0]}), "option goal as"),
        (lambda env: env.reset(seed=-1), "expected seed to be None or a number of 0 or more"),
    ],
)
def test_wrong_calls_change_nothing(call, message):
    a, b = (make(world="empty_room", beams=8) for _ in range(2))
    right = np.float32([0.5, 0.5])
    for env in (a, b):
        env.reset(seed=1)
        env.step(right)

    with pytest.raises(UsageError, match=message):
        call(a)

    assert_same(a.step(right), b.step(right))
    assert_same(a.np_random_seed, b.np_random_seed)
    assert_same(a.reset(), b.reset())


def test_a_picture_and_a_line_of_text_show_the_goal():
    env = make(world="empty_room", render_mode="rgb_array")
    env.reset(options={"start": [0, 0, 0], "goal": [2, 1]})
    frame = env.render()
    assert (frame.shape, frame.dtype) == ((480, 480, 3), np.uint8)
    assert frame[240 - 48, 240 + 96].tolist() == [46, 160, 67]
    env.reset(options={"start": [-4, 0, 0], "goal": [4, 0]})
    assert env.render()[240, 470].tolist() == [46, 160, 67]  # an arrow at the edge
    env = make(world="empty_room", render_mode="ansi")
    env.reset(options={"start": [0, 0, 0], "goal": [2, 1]})
    line = "   0.00 s  robot (0.00, 0.00) m, +0.00 rad  goal (2.00, 1.00) m, 2.24 m away"
    assert env.render() == line


@pytest.mark.parametrize("count", [0, 3])
def test_a_notebook_shows_environments(count):
    env = make_vector(count, world="discs").unwrapped if count else make(world="discs")
    assert env._repr_png_() is None
    env.reset(seed=1)
    picture = Image.open(io.BytesIO(env._repr_png_()))
    assert picture.size == ((484, 484) if count else (480, 480))
    step = 2 if count else 1
    first = env.navigation.picture(0)[::step, ::step][:240, :240]
    assert np.array_equal(np.array(picture)[:240, :240], first)


def test_a_page_in_the_browser_shows_an_environment(monkeypatch):
    pages = []
    monkeypatch.setattr("flatland2d.picture_page.open_in_browser", pages.append)
    env = make(world="empty_room", render_mode="human")
    assert env.metadata["render_modes"] == ["human", "rgb_array", "ansi"]
    env.reset(seed=1)
    with urllib.request.urlopen(f"{pages[0]}pictures") as stream:
        lines = iter(stream.readline, b"")
        assert b"Content-Type: image/jpeg\r\n" in lines
        for _ in range(3):
            assert env.step(FORWARDS)
            assert env.render() is None
        assert b"Content-Type: image/jpeg\r\n" in lines
        env.close()
        assert stream.read().endswith(b"--picture\r\n")
    assert len(pages) == 1


@pytest.mark.skipif(not importlib.util.find_spec("moviepy"), reason="moviepy is not installed")
def test_a_video_is_recorded(tmp_path):
    env = gym.make(ID, world="discs", render_mode="rgb_array", time_limit=1.0)
    env = gym.wrappers.RecordVideo(env, str(tmp_path), episode_trigger=lambda episode: True)
    env.reset(seed=1)
    while not any(env.step(np.zeros(2, np.float32))[2:4]):
        pass
    env.close()
    assert [file.stat().st_size > 1000 for file in tmp_path.glob("*.mp4")] == [True]


@pytest.mark.filterwarnings("ignore:.*Overriding environment")
def test_a_single_environment_runs_with_an_older_gymnasium(monkeypatch):
    monkeypatch.delitem(sys.modules, "flatland_gym")
    monkeypatch.delattr(gym.vector, "AutoresetMode")
    env = gym.make(f"flatland_gym:{ID}", world="empty_room")  # imports it anew, as 0.29 would
    env.reset(seed=1)
    with pytest.raises(MissingPackageError, match=r"NavigationVectorEnv needs Gymnasium 1\.1"):
        sys.modules["flatland_gym"].NavigationVectorEnv  # noqa: B018

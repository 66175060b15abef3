"""Several robots in one world: PettingZoo's tests, and robots that meet."""

import warnings

import numpy as np
import pettingzoo
import pytest
from environments import assert_same
from pettingzoo.test import parallel_api_test, parallel_seed_test, render_test
from pettingzoo.utils import parallel_to_aec

from flatland2d import UsageError
from flatland_gym.multi_robot_env import MultiRobotEnv


def place(env, *poses):
    env.reset(seed=1, options={"start": dict(zip(env.possible_agents, poses))})


@pytest.mark.parametrize("world", ["discs", "corridor"])
def test_it_passes_pettingzoos_tests(world):
    def make():
        return MultiRobotEnv(robots=3, world=world, time_limit=5.0, beams=16)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(make(), num_cycles=300)
        parallel_seed_test(make, num_cycles=60)


def test_pettingzoo_makes_it_by_its_name():
    env = pettingzoo.make("parallel", "flatland/Navigation-v0", robots=3, world="empty_room")

    assert isinstance(env, MultiRobotEnv)
    assert len(env.possible_agents) == 3


def test_it_passes_pettingzoos_render_test_without_a_screen(without_screen):
    modes = []

    def make(render_mode):
        modes.append(render_mode)
        return parallel_to_aec(MultiRobotEnv(world="empty_room", render_mode=render_mode))

    render_test(make)
    assert modes == ["human", "human", "rgb_array"]


def test_robots_see_and_hit_each_other():
    env = MultiRobotEnv(robots=2, world="empty_room", goal_distance=(2.0, 4.0), flatten=False)
    place(env, [-1, 0, 0], [1, 0, np.pi])
    forwards = {agent: np.float32([0.8, 0]) for agent in env.agents}
    observations, *_ = env.step(forwards)
    ahead = observations["robot_0"]["ranges"][32] * 10
    assert ahead == pytest.approx(2 - 0.2 - 2 * 0.005, abs=0.02)

    infos = {}
    for _ in range(40):
        _, rewards, terminated, _, infos = env.step(forwards)
        if any(terminated.values()):
            break
    assert terminated == {"robot_0": True, "robot_1": True}
    assert all(info["collision"] for info in infos.values())
    assert max(rewards.values()) < -9
    assert env.agents == []


def test_a_robot_that_is_done_leaves_the_world():
    env = MultiRobotEnv(robots=3, world="empty_room", flatten=False)
    place(env, [4.7, 0, 0], [2, 0, 0], [-3, -3, 0])
    still = np.zeros(2, np.float32)
    while "robot_0" in env.agents:
        actions = dict.fromkeys(env.agents, still)
        actions["robot_0"] = np.float32([0.8, 0])
        observations, _, terminated, _, _ = env.step(actions)
    assert terminated["robot_0"]
    assert observations["robot_1"]["ranges"][32] * 10 == pytest.approx(2.6, abs=0.05)
    observations, *_ = env.step(dict.fromkeys(env.agents, still))
    assert observations["robot_1"]["ranges"][32] * 10 == pytest.approx(3.0, abs=1e-3)
    assert set(observations) == {"robot_1", "robot_2"}


def test_wrong_calls_change_nothing():
    a, b = (MultiRobotEnv(robots=2, world="empty_room") for _ in range(2))
    assert_same(a.reset(seed=1), b.reset(seed=1))
    right = {agent: np.float32([0.5, 0.1]) for agent in a.agents}
    for wrong, message in (
        (None, "expected a dict of actions by agent, found None"),
        ([right["robot_0"]] * 2, "expected a dict of actions by agent"),
        ({**right, "robot_1": [[1], [2, 3]]}, "expected actions of numbers"),
        ({}, "expected the actions of robot_0, robot_1; found those of none"),
        ({**right, "robot_9": right["robot_0"]}, "found those of robot_0, robot_1, robot_9"),
        ({**right, "robot_1": [0.0, float("nan")]}, "expected finite actions, found nan"),
        ({**right, "robot_1": [0.0]}, r"expected actions of shape \(2,\), found \(1,\)"),
    ):
        with pytest.raises(UsageError, match=message):
            a.step(wrong)
    with pytest.raises(UsageError, match="expected seed to be None or a number of 0 or more"):
        a.reset(seed=-1)
    assert_same(a.step(right), b.step(right))
    for arguments in ({"render_mode": "ansi"}, {"world": None}):
        with pytest.raises(UsageError):
            MultiRobotEnv(**arguments)


def test_starts_and_goals_can_be_given():
    env = MultiRobotEnv(robots=3, world="empty_room", obstacles=4)
    goals = {"robot_0": [3, 0], "robot_2": (0.0, 3.0)}
    for seed in range(20):  # robots that are drawn first keep away from those that are given
        starts = {"robot_1": [-3, 0], "robot_2": np.array([0.0, -3.0, 1.5])}
        _, infos = env.reset(seed=seed, options={"start": starts, "goal": goals})
        assert infos["robot_1"]["pose"][:2] == pytest.approx([-3, 0], abs=1e-6)
        assert infos["robot_2"]["pose"] == pytest.approx([0, -3, 1.5], abs=1e-6)
        assert infos["robot_0"]["goal"].tolist() == [3, 0]
        assert infos["robot_2"]["goal"].tolist() == [0, 3]
        poses = np.array([info["pose"][:2] for info in infos.values()])
        apart = np.linalg.norm(poses[:, None] - poses, axis=-1)[np.triu_indices(3, 1)]
        assert apart.min() > 0.4


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"starts": {}}, "unknown option 'starts'; there are: start, goal, world"),
        ({"start": [0, 0]}, r"start as a dict by agent, of: robot_0, robot_1; found \[0, 0\]"),
        ({"start": {"robot_2": [0, 0]}}, "start as a dict by agent, of: robot_0, robot_1; found"),
        ({"goal": {"robot_1": [0, 0, 0]}}, r"goal of robot_1 as \[x, y\], found \[0, 0, 0\]"),
        ({"start": {"robot_0": "ab"}}, r"of robot_0 as \[x, y\] or \[x, y, yaw\], found 'ab'"),
        ({"goal": {"robot_0": [9, 0]}}, r"a goal of robot_0 that is free .*, found \[9, 0\]"),
        ({"start": {"robot_0": [0, 0], "robot_1": [0.1, 0]}}, "where another model stands"),
        ([], "expected options as a dict"),
        ({"world": "doors"}, "expected the option world to be one of: empty_room"),
    ],
)
def test_wrong_options_change_nothing(options, message):
    a, b = (MultiRobotEnv(robots=2, world="empty_room") for _ in range(2))
    for env in (a, b):
        env.reset(seed=1)
    for seed in (None, 5):
        with pytest.raises(UsageError, match=message):
            a.reset(seed=seed, options=options)
    actions = {agent: np.float32([0.5, 0.1]) for agent in a.agents}
    assert_same(a.step(actions), b.step(actions))
    assert_same(a.reset(), b.reset())


def drive_to_the_goal(at_goal):
    """Robot 0 drives east to its goal at [0, 0]; robot 1 stands west of it, and looks at it."""
    env = MultiRobotEnv(robots=2, world="empty_room", at_goal=at_goal, flatten=False)
    ends = {"start": {"robot_0": [-1, 0, 0], "robot_1": [-3, 0, 0]}, "goal": {"robot_0": [0, 0]}}
    env.reset(seed=1, options=ends)
    infos = {}
    while "robot_0" in env.agents:
        actions = {"robot_0": np.float32([0.5, 0]), "robot_1": np.float32([0, 0])}
        _, _, terminated, _, infos = env.step(actions)
    assert terminated == {"robot_0": True, "robot_1": False}
    assert infos["robot_0"]["success"]
    return env


def test_a_robot_can_stay_at_its_goal():
    env = drive_to_the_goal("stay")
    forwards = {"robot_1": np.float32([0.5, 0])}
    seen = []
    while env.agents:
        observations, *_, infos = env.step(forwards)
        seen.append(observations["robot_1"]["ranges"][32] * 10)
    assert 2 < seen[0] < 3  # robot 0, not the wall at 8 m
    assert infos["robot_1"]["collision"]  # with robot 0
    env = drive_to_the_goal("leave")
    observations, *_ = env.step(forwards)
    assert observations["robot_1"]["ranges"][32] * 10 > 7


def test_rewards_can_be_shared():
    own, half, whole = (
        MultiRobotEnv(robots=3, world="empty_room", shared_rewards=part) for part in (0, 0.5, 1)
    )
    for env in (own, half, whole):
        env.reset(seed=3)
    for _ in range(60):
        actions = {agent: np.float32([0.4, 0.3]) for agent in own.agents}
        rewards, halves, means = (env.step(actions)[1] for env in (own, half, whole))
        mean = np.mean(list(rewards.values()))  # of those that acted
        assert means == pytest.approx(dict.fromkeys(rewards, mean))
        assert halves == pytest.approx({a: (r + mean) / 2 for a, r in rewards.items()})
        assert own.agents == whole.agents


def test_the_state_describes_all_robots():
    env = drive_to_the_goal("leave")
    state = env.state()
    assert env.state_space.contains(state)
    gone, there = state.reshape(2, 10)
    assert not gone.any()
    _, _, _, _, infos = env.step({"robot_1": np.float32([0.5, 0.2])})
    there = env.state()[10:]
    x, y, yaw = infos["robot_1"]["pose"]
    assert there[:4] == pytest.approx([x, y, np.cos(yaw), np.sin(yaw)], abs=1e-6)
    assert there[4] > 0
    assert there[7:9] == pytest.approx(infos["robot_1"]["goal"])
    assert there[9] == 1

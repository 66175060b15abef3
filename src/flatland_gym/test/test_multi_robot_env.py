"""Several robots in one world: PettingZoo's tests, and robots that meet."""

import warnings

import numpy as np
import pytest
from environments import assert_same
from pettingzoo.test import parallel_api_test, parallel_seed_test, render_test
from pettingzoo.utils import parallel_to_aec

from flatland2d import UsageError
from flatland_gym.multi_robot_env import MultiRobotEnv


def place(env, *poses):
    """Puts the robots at poses, and updates their observations."""
    for name, pose in zip(env.possible_agents, poses):
        env._navigation.simulation(0).move(name, pose)


@pytest.mark.parametrize("world", ["discs", "corridor"])
def test_it_passes_pettingzoos_tests(world):
    def make():
        return MultiRobotEnv(robots=3, world=world, time_limit=5.0, beams=16)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(make(), num_cycles=300)
        parallel_seed_test(make, num_cycles=60)


def test_it_passes_pettingzoos_test_of_rendering_without_a_screen(without_screen):
    modes = []

    def make(render_mode):
        modes.append(render_mode)
        return parallel_to_aec(MultiRobotEnv(world="empty_room", render_mode=render_mode))

    render_test(make)
    assert modes == ["human", "human", "rgb_array"]


def test_robots_see_and_hit_each_other():
    env = MultiRobotEnv(robots=2, world="empty_room", goal_distance=(2.0, 4.0), flatten=False)
    env.reset(seed=1)
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
    env.close()


def test_a_robot_that_is_done_leaves_the_world():
    env = MultiRobotEnv(robots=3, world="empty_room", flatten=False)
    env.reset(seed=1)
    place(env, [4.75, 0, 0], [2, 0, 0], [-3, -3, 0])
    still = np.zeros(2, np.float32)
    _, _, terminated, _, _ = env.step(
        {"robot_0": np.float32([0.8, 0]), "robot_1": still, "robot_2": still}
    )
    while "robot_0" in env.agents:
        actions = dict.fromkeys(env.agents, still)
        actions["robot_0"] = np.float32([0.8, 0])
        observations, _, terminated, _, _ = env.step(actions)
    assert terminated["robot_0"]
    assert observations["robot_1"]["ranges"][32] * 10 == pytest.approx(2.6, abs=0.05)
    observations, *_ = env.step(dict.fromkeys(env.agents, still))
    assert observations["robot_1"]["ranges"][32] * 10 == pytest.approx(3.0, abs=1e-3)
    assert set(observations) == {"robot_1", "robot_2"}
    env.close()


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
    for arguments in (
        {"robots": 1},
        {"world": ("discs", "doors")},
        {"render_mode": "ansi"},
        {"world": None},
    ):
        with pytest.raises(UsageError):
            MultiRobotEnv(**arguments)


def test_a_picture():
    env = MultiRobotEnv(robots=2, world="discs", render_mode="rgb_array")
    env.reset(seed=1)
    assert env.render().shape == (480, 480, 3)
    env.close()

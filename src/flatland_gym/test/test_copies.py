"""Environments that are pickled and copied: other ones by the same arguments, without a state."""

import copy
import pickle

import numpy as np
import pytest

pytest.importorskip("gymnasium")

import gymnasium as gym
from environments import ID, assert_same, make_vector

from flatland2d import UsageError
from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv

ARGUMENTS = {"world": "discs", "beams": 8, "time_limit": 5.0}


def make_wrapped():
    return gym.make(ID, **ARGUMENTS, max_episode_steps=3)


def make_team():
    multi_robot_env = pytest.importorskip("flatland_gym.multi_robot_env")
    return multi_robot_env.MultiRobotEnv(3, at_goal="stay", **ARGUMENTS)


MAKERS = {
    "single": make_wrapped,
    "batch": lambda: make_vector(2, autoreset_mode="SameStep", **ARGUMENTS),
    "team": make_team,
    "teams": lambda: MultiRobotVectorEnv(2, 3, **ARGUMENTS),
}


def drive(env):
    """The results of a reset and some steps."""
    results = [env.reset(seed=3)]
    rng = np.random.default_rng(1)
    for _ in range(8):
        if hasattr(env, "agents"):
            spaces = {agent: env.action_space(agent) for agent in env.agents}
            actions = {agent: rng.uniform(0.0, 1.0, each.shape) for agent, each in spaces.items()}
        else:
            actions = rng.uniform(0.0, 1.0, env.action_space.shape)
        results.append(env.step(actions))
    return results


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("kind", MAKERS)
def test_a_copy_is_made_by_the_same_arguments(kind, copied):
    env = MAKERS[kind]()
    fresh = copied(env)
    expected = drive(env)
    used = copied(env)  # in an episode, which is not copied
    actions = {"robot_0": [0.0, 0.0]} if kind == "team" else env.action_space.sample()
    with pytest.raises(UsageError, match=r"expected reset before step|found those of"):
        used.unwrapped.step(actions)

    assert_same(drive(fresh), expected)
    assert_same(drive(used), expected)

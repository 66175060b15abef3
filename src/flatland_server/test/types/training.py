# pyright: strict, reportUnknownMemberType=false, reportUninitializedInstanceVariable=false
"""A user's training program, for scripts/check: type checkers find the types asserted here."""

from typing import Any

import gymnasium as gym
from typing_extensions import assert_type

import flatland_gym
from flatland_gym import NavigationVectorEnv, Policy, RewardWeights, Transition
from flatland_gym.evaluation import evaluate
from flatland_gym.train import Ppo
from flatland_navigation.grid import Grid
from flatland_navigation.navigator import Navigator, NavigatorConfig
from flatland_server import FloatArray


def reward(transition: Transition, weights: RewardWeights) -> FloatArray:
    """A reward of one's own."""
    return flatland_gym.navigation_reward(transition, weights) - 0.1


def train() -> float:
    """Trains and evaluates."""
    env: gym.Env[Any, Any] = gym.make("flatland/Navigation-v0", world="office")
    env.reset(seed=1)
    training = NavigationVectorEnv(16, world="empty_room", autoreset_mode="SameStep")
    assert_type(training.single_action_space, gym.spaces.Box)
    policy = Ppo(training, seed=1).train(steps=2000)
    assert_type(policy, Policy)
    policy.save("policy.npz")
    result = evaluate(policy, seeds=range(5), world="empty_room")
    return float(result.success.mean())


def navigator(grid: Grid) -> Navigator:
    """Flatland's own navigation."""
    return Navigator(grid, NavigatorConfig())

"""Flatland's worlds for reinforcement learning: Gymnasium, PettingZoo and Stable-Baselines3.

    import gymnasium as gym
    import flatland_gym

    env = gym.make("flatland/Navigation-v0", world="office")
    envs = gym.make_vec("flatland/Navigation-v0", num_envs=64, world="discs")

Importing it registers the environments. docs/learning.md describes them.
"""

import gymnasium

from flatland_gym.navigation_env import NavigationEnv
from flatland_gym.navigation_vector_env import NavigationVectorEnv
from flatland_gym.rewards import RewardWeights, Transition, navigation_reward
from flatland_gym.scenarios import SCENARIOS, Scenario
from flatland_gym.settings import NavigationSettings

__all__ = [
    "SCENARIOS",
    "NavigationEnv",
    "NavigationSettings",
    "NavigationVectorEnv",
    "RewardWeights",
    "Scenario",
    "Transition",
    "navigation_reward",
]

gymnasium.register(
    id="flatland/Navigation-v0",
    entry_point="flatland_gym.navigation_env:NavigationEnv",
    vector_entry_point="flatland_gym.navigation_vector_env:NavigationVectorEnv",
)

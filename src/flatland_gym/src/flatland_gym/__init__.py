"""Flatland's worlds for reinforcement learning: Gymnasium, PettingZoo and Stable-Baselines3.

    import gymnasium as gym
    import flatland_gym

    env = gym.make("flatland/Navigation-v0", world="office")
    envs = gym.make_vec("flatland/Navigation-v0", num_envs=64, world="discs")

Importing it registers the environments. docs/learning.md describes them. Policies can be used
without Gymnasium.
"""

import importlib.util
from typing import TYPE_CHECKING, Any

from flatland2d import MissingPackageError
from flatland_gym.policy import Policy
from flatland_gym.rewards import RewardWeights, Transition, navigation_reward
from flatland_gym.rooms import Rooms
from flatland_gym.scenarios import SCENARIOS, Scenario
from flatland_gym.settings import NavigationSettings
from flatland_server.exceptions import pip_install

__all__ = [
    "SCENARIOS",
    "MapCrop",
    "NavigationEnv",
    "NavigationSettings",
    "NavigationVectorEnv",
    "ObservationPart",
    "Policy",
    "RewardWeights",
    "Rooms",
    "Scenario",
    "Situation",
    "Transition",
    "navigation_reward",
]

if TYPE_CHECKING or importlib.util.find_spec("gymnasium") is not None:
    import gymnasium

    from flatland_gym.navigation_env import NavigationEnv
    from flatland_gym.parts import MapCrop, ObservationPart, Situation

    if TYPE_CHECKING or hasattr(gymnasium.vector, "AutoresetMode"):  # Gymnasium 1.1 and later
        from flatland_gym.navigation_vector_env import NavigationVectorEnv

    gymnasium.register(
        id="flatland/Navigation-v0",
        entry_point="flatland_gym.navigation_env:NavigationEnv",
        vector_entry_point="flatland_gym.navigation_vector_env:NavigationVectorEnv",
    )
    if importlib.util.find_spec("pettingzoo") is not None:
        import pettingzoo

        if hasattr(pettingzoo, "register"):  # PettingZoo 1.27 and later
            pettingzoo.register(
                "parallel",
                "flatland/Navigation-v0",
                entry_point="flatland_gym.multi_robot_env:MultiRobotEnv",
            )


def __getattr__(name: str) -> Any:
    """Raises the error for environments if Gymnasium is missing or too old."""
    if name in __all__:
        wanted = "Gymnasium 1.1" if "NavigationEnv" in globals() else "Gymnasium"
        raise MissingPackageError(f"{name} needs {wanted}: {pip_install('gym')}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

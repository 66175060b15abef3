"""Evaluation of a policy: success, collisions and durations."""

from typing import Any, NamedTuple, Sequence

import numpy as np

from flatland_gym.navigation_vector_env import NavigationVectorEnv
from flatland_gym.policy import Policy
from flatland_server import BoolArray, FloatArray


class Evaluation(NamedTuple):
    """The results of an episode for each seed."""

    success: BoolArray
    """True if the goal was reached."""
    collision: BoolArray
    """True if the robot has collided."""
    seconds: FloatArray
    """Duration of each episode [s]."""


def evaluate(
    policy: Policy, seeds: Sequence[int], threads: int = 1, **arguments: Any
) -> Evaluation:
    """Runs an episode of each seed; its result does not depend on the other seeds.

    Args:
        policy: drives the robot.
        seeds: of the environments.
        threads: how many are stepped at a time.
        arguments: of the environment; see `NavigationSettings`.
    """
    env = NavigationVectorEnv(len(seeds), threads, autoreset_mode="Disabled", **arguments)
    try:
        observations, _ = env.reset(seed=list(seeds))
        navigation = env.navigation
        running = np.arange(len(seeds))
        success, collision = (np.zeros(len(seeds), bool) for _ in range(2))
        while len(running):
            limits = env.action_space.shape or ()
            actions = navigation.checked_actions(policy.act(observations), limits)
            _, terminated, truncated = navigation.step(actions, running)
            observations = navigation.observe()
            success |= navigation.successes
            collision[running] |= navigation.rows.collided[running]
            running = running[~(terminated | truncated)[running]]
        return Evaluation(success, collision, navigation.steps * navigation.settings.period)
    finally:
        env.close()

"""Evaluation of a policy: success, collisions and durations."""

from typing import Any, NamedTuple, Sequence, Union

import numpy as np

from flatland_gym.navigation_vector_env import NavigationVectorEnv
from flatland_gym.policy import Policy
from flatland_server import BoolArray, Float32Array, FloatArray


class StraightDriver:
    """Turns to the goal and drives at it, whatever is in the way: shows how much a world asks for.

    Args:
        beams: number of the lidar's beams.
        size: of an action: the speed comes first, what turns the robot last.
        speed: at most that of the robot [m/s].
    """

    def __init__(self, beams: int, size: int = 2, speed: float = 0.8) -> None:
        self._beams, self._size, self._speed = beams, size, speed

    def act(self, observations: Float32Array) -> FloatArray:
        """Actions for flat observations, shape (n, size of an action)."""
        bearings = np.arctan2(observations[:, self._beams + 2], observations[:, self._beams + 1])
        found = np.zeros((len(observations), self._size))
        found[:, 0] = np.where(np.abs(bearings) < 0.5, self._speed, 0.0)
        found[:, -1] = 3.0 * bearings
        return found


class Evaluation(NamedTuple):
    """The results of an episode for each seed."""

    success: BoolArray
    """True if the goal was reached."""
    collision: BoolArray
    """True if the robot has collided."""
    seconds: FloatArray
    """Duration of each episode [s]."""


def evaluate(
    policy: Union[Policy, StraightDriver], seeds: Sequence[int], threads: int = 1, **arguments: Any
) -> Evaluation:
    """Runs an episode of each seed; its result does not depend on the other seeds.

    Args:
        policy: policy that drives the robot.
        seeds: a seed for each episode.
        threads: number of environments that are stepped at a time.
        arguments: of the environment; see `NavigationSettings`.

    Raises:
        FlatlandError: an argument is wrong, or the policy cannot have these observations.
    """
    env = NavigationVectorEnv(len(seeds), threads, autoreset_mode="Disabled", **arguments)
    try:
        observations, _ = env.reset(seed=list(seeds))
        navigation = env.navigation
        if isinstance(policy, (Policy, StraightDriver)):
            navigation.require_standard()
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

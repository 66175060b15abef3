"""Robots that share a world: the common part of environments with several robots, one or many."""

import sys
from typing import Any

import numpy as np

from flatland2d import UsageError
from flatland_gym.navigation import Navigation, Steps
from flatland_gym.settings import NavigationSettings, is_whole
from flatland_server import Float32Array, FloatArray, cos_sin

AT_GOAL = ("leave", "stay")
"""Fates of a robot that has reached its goal."""

STATE_SIZE = 10
"""Numbers of each robot in `Team.state`."""


class Team:
    """The m robots of each of n environments: those that are there, shared rewards, the state.

    Args:
        navigation: of n environments with m robots.
        at_goal: one of `AT_GOAL`.
        shared_rewards: the part of each reward that is replaced by the mean over the team.
        most_steps: after which an episode is truncated, besides the settings' time limit.

    Attributes:
        present: the robots that act in the next step, shape (n, m).
    """

    def __init__(
        self,
        navigation: Navigation,
        at_goal: str,
        shared_rewards: float,
        most_steps: int = sys.maxsize,
    ) -> None:
        self._navigation = navigation
        self._stays = at_goal == "stay"
        self._shared = float(shared_rewards)
        self._most_steps = most_steps
        robots = len(navigation.robot_names)
        self.present = np.zeros((len(navigation.goals) // robots, robots), dtype=bool)

    def step(self, actions: FloatArray) -> Steps:
        """Makes a step with the robots that are there; those that are done leave or stand still.

        Args:
            actions: of all robots, as `Navigation.checked_actions` returns them, with the shape
                (n * m, size of an action).

        Returns:
            New arrays of shape (n, m); those of other robots are 0 and False.
        """
        navigation, shape = self._navigation, self.present.shape
        acting = self.present.copy()
        rewards, terminated, truncated = navigation.step(actions, np.flatnonzero(acting))
        rewards, terminated = rewards.reshape(shape), terminated.reshape(shape)
        is_long = navigation.steps.reshape(shape) >= self._most_steps
        truncated = truncated.reshape(shape) | (acting & is_long)
        ended = terminated | truncated
        self.present &= ~ended
        # An environment without robots is not stepped before it is reset.
        retired = ended & self.present.any(axis=1, keepdims=True)
        if retired.any():
            leaving = retired.ravel()
            if self._stays:
                leaving = leaving & ~navigation.successes
            navigation.retire(np.flatnonzero(retired), leaving)
        return self._share(rewards, acting), terminated, truncated

    def state(self) -> Float32Array:
        """The state of all robots: a new array of shape (n, m * 10), float32.

        For each robot, in the order of its name: x, y [m], cosine and sine of its yaw, velocities
        forwards, to the left and turning [m/s, m/s, rad/s], x and y of its goal [m], and 1. All are
        0 if its episode has ended.
        """
        rows, there = self._navigation.rows, np.flatnonzero(self.present)
        poses = rows.poses[there]
        state = np.zeros((self.present.size, STATE_SIZE), np.float32)
        state[there, :2] = poses[:, :2]
        state[there, 2:4] = np.stack(cos_sin(poses[:, 2]), axis=1)
        state[there, 4:7] = rows.local_velocities[there]
        state[there, 7:9] = self._navigation.goals[there]
        state[there, 9] = 1.0
        return state.reshape(len(self.present), -1)

    def _share(self, rewards: FloatArray, acting: Any) -> FloatArray:
        """Rewards with the part that the robots of an environment share."""
        if self._shared == 0.0:
            return rewards
        total = np.zeros(len(rewards))
        for column in rewards.T:  # in this order for any number of environments
            total += column
        mean = total / np.maximum(acting.sum(axis=1), 1)
        shared: FloatArray = (1.0 - self._shared) * rewards + self._shared * mean[:, None]
        return np.where(acting, shared, 0.0)


def check_team(
    robots: Any, at_goal: Any, shared_rewards: Any, settings: NavigationSettings
) -> None:
    """Raises a UsageError for arguments that no team can have."""
    if not (is_whole(robots) and robots >= 2):
        raise UsageError(f"expected robots to be a whole number of 2 or more, found {robots!r}")
    if at_goal not in AT_GOAL:
        known = ", ".join(map(repr, AT_GOAL))
        raise UsageError(f"expected at_goal to be one of {known}, found {at_goal!r}")
    is_number = isinstance(shared_rewards, (int, float, np.number))
    if not is_number or isinstance(shared_rewards, bool) or not 0.0 <= shared_rewards <= 1.0:
        raise UsageError(
            f"expected shared_rewards to be a number from 0 to 1, found {shared_rewards!r}"
        )
    if len(settings.worlds) != 1 or len(settings.robot_scales) != 1:
        raise UsageError("expected one world and one of robot_scales, found several")

"""Navigation of one robot: `flatland/Navigation-v0` as Gymnasium's Env makes it.

NumPy takes a microsecond for an operation on arrays of one row, and a step has seventy. Here they
are Python's numbers, by the same formulas: results are those of `Navigation`, bit for bit.
"""

import math
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np

from flatland_gym.navigation import Navigation, numbers_of
from flatland_gym.settings import NavigationSettings

Result = Tuple[Any, float, bool, bool, Dict[str, Any]]
"""Observation, reward, termination, truncation and info."""


_ONE = np.array([0])


class SingleNavigation(Navigation):
    """A robot in a single environment.

    Args:
        settings: what the environment is.

    Raises:
        FlatlandError: a world cannot be used.
    """

    def __init__(self, settings: NavigationSettings) -> None:
        super().__init__(settings)
        self._has_functions = settings.reward is not None or settings.terminated is not None
        # Python's numbers also where NumPy's were given.
        self._goal_radius = float(settings.goal_radius)
        self._collision_ends = bool(settings.collision_ends)

    def drive(self, action: Any) -> Result:
        """Makes a step.

        Args:
            action: the action, which is checked here.

        Raises:
            UsageError: the action has another shape, is no number or not finite. The environment is
                as before.
        """
        state = self.rows
        command = self._command(action)
        self._fleet(self._world_of.item(0)).drive(command)
        (x, y, _), (goal_x, goal_y) = state.poses[0].tolist(), self.goals[0].tolist()
        collided = state.collided.item(0)
        # C's hypot, as NumPy's; math.hypot differs in the last bit.
        distance = abs(complex(goal_x - x, goal_y - y))
        success = distance < self._goal_radius and not collided
        if self._has_functions:
            numbers = np.array([distance]), np.array([success]), np.array([command])
            (reward,), (terminated,) = (each.tolist() for each in self._evaluate(*numbers, _ONE))
        else:
            reward = self.settings.rewards.reward(
                self.distances.item(0) - distance, success, collided, self._period
            )
            terminated = success or (collided and self._collision_ends)
        steps = self.steps.item(0) + 1
        self.steps[0], self.distances[0], self.successes[0] = steps, distance, success
        truncated = not terminated and steps >= self._longest_episode
        info = self._info(success, collided, distance)
        return self.observation(), reward, terminated, truncated, info

    def begin(
        self, generator: np.random.Generator, options: Optional[Mapping[str, Any]]
    ) -> Tuple[Any, Dict[str, Any]]:
        """Begins an episode; returns its observation and info.

        Args:
            generator: the random numbers.
            options: as for `reset`.

        Raises:
            UsageError: an option is wrong. The environment is as before.
        """
        self.reset(_ONE, [generator], options)
        return self.observation(), self._info(False, False, self.distances.item(0))

    def observation(self) -> Any:
        """The observation of the robot: new arrays."""
        return self.formed(self.observe()[0])

    def _info(self, success: bool, collided: bool, distance: float) -> Dict[str, Any]:
        """The info of the robot, with new arrays."""
        info = {
            "success": success,
            "collision": collided,
            "distance": distance,
            "pose": self.rows.poses[0].copy(),
            "goal": self.goals[0].copy(),
        }
        if self._maps is not None:
            info["map"] = self._map_of.item(0)
        if self.settings.vary:
            info["vary"] = self._vary[0].copy()
        if self._privileged is not None:
            info["privileged"] = self.privileged()[0]
        return info

    def _command(self, action: Any) -> List[float]:
        """An action, cut to the limits; as `checked_actions`."""
        limits = self.robot.action_limits
        values = numbers_of(action, (len(limits),)).tolist()
        if not math.isfinite(sum(values)):  # fast path: a finite sum has finite terms
            command: List[float] = self.checked_actions(action, (len(limits),)).tolist()
            return command
        return [float(min(max(v, -limit), limit)) for v, limit in zip(values, limits)]

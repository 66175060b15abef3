"""`flatland/Navigation-v0` for one robot: Gymnasium's Env."""

import math
from typing import Any, Dict, List, Mapping, Optional, Tuple

import gymnasium
import numpy as np
from gymnasium import spaces

from flatland2d import UsageError
from flatland2d.rendering.film import side_by_side
from flatland_gym.navigation import Navigation, numbers_of
from flatland_gym.pickling import ByArguments
from flatland_gym.pictures import RENDER_MODES, check_render_mode, page_of
from flatland_gym.settings import NavigationSettings, require_seed

Result = Tuple[Any, float, bool, bool, Dict[str, Any]]
"""Observation, reward, termination, truncation and info."""

_ONE = np.array([0])


class SingleNavigation(Navigation):
    """A robot in a single environment.

    NumPy takes a microsecond for an operation on arrays of one row, and a step has seventy. Here
    they are Python's numbers, by the same formulas: results are those of `Navigation`, bit for bit.

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


class NavigationEnv(ByArguments, gymnasium.Env[Any, Any]):
    """A robot drives to a goal at a known distance and bearing, around what its lidar sees.

    docs/learning.md describes observations, actions and rewards.

    Args:
        render_mode: None, "human" (a page in the browser), "rgb_array" or "ansi" (a line of text).
        arguments: the attributes of `NavigationSettings`.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    metadata: Dict[str, Any] = {"render_modes": list(RENDER_MODES)}  # noqa: RUF012 (Gymnasium's)
    _np_random: Optional[np.random.Generator] = None  # Gymnasium's, kept here where a reset fails
    _np_random_seed: Optional[int] = None

    def __init__(self, render_mode: Optional[str] = None, **arguments: Any) -> None:
        check_render_mode(render_mode)
        self.render_mode = render_mode
        self.navigation = SingleNavigation(NavigationSettings.of(arguments))
        self.metadata = self.navigation.metadata
        self.action_space: spaces.Box = self.navigation.action_space
        self.observation_space = self.navigation.observation_space
        self._page = page_of(render_mode, self.navigation.settings.period)
        self._is_running = False

    @property
    def reset_options(self) -> Dict[str, Any]:
        """Options of all resets from now on, also of automatic ones: a curriculum's.

        Those that are given to `reset` come first. Setting a wrong one raises a UsageError, and
        changes nothing.
        """
        return self.navigation.options

    @reset_options.setter
    def reset_options(self, options: Optional[Mapping[str, Any]]) -> None:
        self.navigation.options = options

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None
    ) -> Tuple[Any, Dict[str, Any]]:
        """Begins an episode.

        Args:
            seed: of the random numbers from now on; None goes on with those there are.
            options: `start` ([x, y] or [x, y, yaw]) and `goal` ([x, y]), which are otherwise drawn;
                `world`, `goal_distance`, `margin`, `obstacles`, `robot_scales` and `vary` in place
                of the arguments, within what these allow.

        Raises:
            UsageError: an option is wrong, such as a goal in a wall. The environment is as before.
        """
        former = self._np_random, self._np_random_seed
        super().reset(seed=require_seed(seed))
        try:
            result = self.navigation.begin(self.np_random, options)
        except BaseException:
            self._np_random, self._np_random_seed = former
            raise
        self._is_running = True
        if self.render_mode == "human":
            self.render()
        return result

    def step(self, action: Any) -> Tuple[Any, float, bool, bool, Dict[str, Any]]:
        """Drives for `frame_skip` steps.

        Args:
            action: within `action_space`; what is beyond its limits is cut to them.

        Raises:
            UsageError: the action has another shape, is no number or not finite, or there was no
                reset. The environment is as before.
        """
        if not self._is_running:
            raise UsageError("expected reset before step")
        result = self.navigation.drive(action)
        if self.render_mode == "human":
            self.render()
        return result

    def render(self) -> Any:
        """A picture or a line of text, as the render mode says."""
        if self.render_mode is None or not self._is_running:
            return None
        if self.render_mode == "ansi":
            return self.navigation.status(0)
        frame = self.navigation.picture(0)
        if self._page is None:
            return frame
        self._page.show(frame)
        return None

    def _repr_png_(self) -> Optional[bytes]:
        """The picture that a notebook shows of an environment; None before the first reset."""
        return side_by_side([self.navigation.picture(0)]) if self._is_running else None

    def close(self) -> None:
        """Ends the simulation, and closes the page."""
        self._is_running = False
        self.navigation.close()
        if self._page is not None:
            self._page.close()

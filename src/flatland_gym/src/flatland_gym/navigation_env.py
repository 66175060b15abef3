"""`flatland/Navigation-v0` for one robot: Gymnasium's Env."""

from typing import Any, Dict, Mapping, Optional, Tuple

import gymnasium
import numpy as np
from gymnasium import spaces

from flatland2d import UsageError
from flatland2d.rendering.film import side_by_side
from flatland_gym.pickling import ByArguments
from flatland_gym.pictures import RENDER_MODES, check_render_mode, page_of
from flatland_gym.settings import NavigationSettings, require_seed
from flatland_gym.single_navigation import SingleNavigation

_ONE = np.array([0])


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

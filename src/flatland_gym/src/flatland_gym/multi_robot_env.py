"""Several robots in one world that see and hit each other: PettingZoo's ParallelEnv."""

from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np
from gymnasium.utils import seeding

from flatland2d import MissingPackageError, UsageError
from flatland_gym.navigation import Navigation, row_of
from flatland_gym.navigation_world import parking_place
from flatland_gym.pictures import Window, check_render_mode, usable
from flatland_gym.settings import NavigationSettings, is_whole, require_seed
from flatland_server import FloatArray, IntArray

try:
    from pettingzoo import ParallelEnv
except ImportError:
    raise MissingPackageError(
        "flatland_gym.multi_robot_env needs PettingZoo: pip install 'flatland2d[gym]'"
    ) from None


_RENDER_MODES = ("human", "rgb_array")


class MultiRobotEnv(ParallelEnv[str, Any, Any]):
    """Robots in one world that each drive to a goal of their own, past each other.

    Observations, actions and rewards of each are those of `NavigationEnv`. A robot leaves
    the world when its episode has ended. The agents are called robot_0, robot_1 ... after the
    world's robot.

    Args:
        robots: how many there are, two at least: each one like the world's robot.
        render_mode: None, or the surroundings of the first robot that is there: "rgb_array", or
            "human" (a window).
        arguments: the attributes of `NavigationSettings`.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    def __init__(
        self, robots: int = 2, render_mode: Optional[str] = None, **arguments: Any
    ) -> None:
        if not (is_whole(robots) and robots >= 2):
            raise UsageError(f"expected robots to be a whole number of 2 or more, found {robots!r}")
        check_render_mode(render_mode, _RENDER_MODES)
        settings = NavigationSettings.of(arguments)
        if len(settings.worlds) != 1 or len(settings.robot_scales) != 1:
            raise UsageError("expected one world and one of robot_scales, found several")
        navigation = self._navigation = Navigation(settings, robots=int(robots))
        self.metadata = {
            **navigation.metadata,
            "name": "flatland_navigation_v0",
            "render_modes": usable(_RENDER_MODES),
            "is_parallelizable": True,
        }
        self.render_mode = render_mode
        self._window = Window("Flatland", settings.period)
        self.possible_agents = list(navigation.robot_names)
        self.agents: List[str] = []
        self._rng: Optional[np.random.Generator] = None
        self.observation_spaces = dict.fromkeys(self.possible_agents, navigation.observation_space)
        # A space of its own for each agent, so that each has its own seed.
        self.action_spaces = {
            agent: navigation.robot.action_space() for agent in self.possible_agents
        }

    def observation_space(self, agent: str) -> Any:
        """The space of an agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        """The space of an agent's actions."""
        return self.action_spaces[agent]

    def reset(
        self, seed: Optional[int] = None, options: Optional[Mapping[str, Any]] = None
    ) -> Tuple[Dict[str, Any], Dict[str, Any]]:
        """Begins an episode of all robots.

        Args:
            seed: of the random numbers from now on; None goes on with those there are.
            options: ignored.

        Raises:
            UsageError: the seed is wrong, or there is no room for all robots.
        """
        number = require_seed(seed)
        if number is not None or self._rng is None:
            self._rng, _ = seeding.np_random(number)
        self._navigation.reset(np.array([0]), [self._rng])
        self.agents = list(self.possible_agents)
        if self.render_mode == "human":
            self.render()
        return self._observations(), self._infos()

    def step(
        self, actions: Mapping[str, Any]
    ) -> Tuple[Dict[str, Any], Dict[str, float], Dict[str, bool], Dict[str, bool], Dict[str, Any]]:
        """Drives all robots that are there for `frame_skip` steps.

        Args:
            actions: of each agent in `agents`.

        Raises:
            UsageError: an action is missing, or is not usable. The environment is as before.
        """
        agents, rows = list(self.agents), self._rows()
        results = self._navigation.step(self._commands(actions), rows)
        rewards, terminated, truncated = (self._by_agent(values) for values in results)
        observations, infos = self._observations(), self._infos()
        for agent, row in zip(agents, rows.tolist()):
            if terminated[agent] or truncated[agent]:
                self.agents.remove(agent)
                self._remove(agent, row)
        if self.render_mode == "human":
            self.render()
        return observations, rewards, terminated, truncated, infos

    def render(self) -> Any:
        """A picture: uint8, shape (480, 480, 3); None without one, or if a window shows it."""
        if self.render_mode is None or not self.agents:
            return None
        frame = self._navigation.picture(int(self._rows()[0]))
        if self.render_mode == "rgb_array":
            return frame
        self._window.show(frame)
        return None

    def close(self) -> None:
        """Ends the simulation, and closes the window."""
        self.agents = []
        self._navigation.close()
        self._window.close()

    def _rows(self) -> IntArray:
        """The rows of the robots that are there."""
        return np.array([self.possible_agents.index(agent) for agent in self.agents], dtype=int)

    def _by_agent(self, values: Any) -> Dict[str, Any]:
        return {agent: values[row].item() for agent, row in zip(self.agents, self._rows())}

    def _commands(self, actions: Mapping[str, Any]) -> FloatArray:
        """The actions of all robots; zeros for robots that have left."""
        if not isinstance(actions, Mapping):
            raise UsageError(f"expected a dict of actions by agent, found {actions!r:.80}")
        if set(actions) != set(self.agents):
            raise UsageError(
                f"expected the actions of {', '.join(self.agents) or 'no agents'}; "
                f"found those of {', '.join(map(str, actions)) or 'none'}"
            )
        size = len(self._navigation.robot.action_limits)
        commands = np.zeros((len(self.possible_agents), size))
        for agent, row in zip(self.agents, self._rows()):
            commands[row] = self._navigation.checked_actions(actions[agent], (size,))
        return commands

    def _remove(self, agent: str, row: int) -> None:
        """Takes a robot out of the way, and stops it."""
        simulation = self._navigation.simulation(row)
        simulation.models[agent].command(*[0.0] * len(self._navigation.robot.action_limits))
        simulation.move(agent, parking_place(-1 - row))

    def _observations(self) -> Dict[str, Any]:
        flat = self._navigation.observe()
        return {
            agent: self._navigation.formed(flat[row])
            for agent, row in zip(self.agents, self._rows())
        }

    def _infos(self) -> Dict[str, Any]:
        infos = self._navigation.info()
        return {agent: row_of(infos, row) for agent, row in zip(self.agents, self._rows())}

"""Several robots in one world that see and hit each other: PettingZoo's ParallelEnv."""

from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding

from flatland2d import MissingPackageError, UsageError
from flatland_gym.episodes import options_of
from flatland_gym.navigation import Navigation, row_of
from flatland_gym.pickling import ByArguments
from flatland_gym.pictures import check_render_mode, page_of
from flatland_gym.settings import NavigationSettings, require_seed
from flatland_gym.team import STATE_SIZE, Team, check_team
from flatland_server import FloatArray, IntArray
from flatland_server.exceptions import pip_install

try:
    from pettingzoo import ParallelEnv
except ImportError:
    raise MissingPackageError(
        f"flatland_gym.multi_robot_env needs PettingZoo: {pip_install('gym')}"
    ) from None


_RENDER_MODES = ("human", "rgb_array")


class MultiRobotEnv(ByArguments, ParallelEnv[str, Any, Any]):
    """Robots in one world that each drive to a goal of their own, past each other.

    Observations, actions and rewards of each are those of `NavigationEnv`. A robot leaves
    the world when its episode has ended. The agents are called robot_0, robot_1 ... after the
    world's robot.

    Args:
        robots: how many there are, two at least: each one like the world's robot.
        render_mode: None, or the area around the first robot that is there: "rgb_array", or "human"
            (a page in the browser).
        at_goal: "leave", or "stay": a robot that has reached its goal stops and stays in the world,
            where others see and hit it. Its episode has ended, too.
        shared_rewards: the part of each reward that is replaced by the mean of the rewards of all
            robots that acted in the step: 0 for rewards of their own, 1 for the same ones.
        arguments: the attributes of `NavigationSettings`.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    def __init__(
        self,
        robots: int = 2,
        render_mode: Optional[str] = None,
        at_goal: str = "leave",
        shared_rewards: float = 0.0,
        **arguments: Any,
    ) -> None:
        check_render_mode(render_mode, _RENDER_MODES)
        settings = NavigationSettings.of(arguments)
        check_team(robots, at_goal, shared_rewards, settings)
        navigation = self._navigation = Navigation(settings, robots=int(robots))
        self.metadata = {
            **navigation.metadata,
            "name": "flatland_navigation_v0",
            "render_modes": list(_RENDER_MODES),
            "is_parallelizable": True,
        }
        self._team = Team(navigation, at_goal, shared_rewards)
        self.state_space = spaces.Box(-np.inf, np.inf, (STATE_SIZE * int(robots),), np.float32)
        self.render_mode = render_mode
        self._page = page_of(render_mode, settings.period)
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
            options: `start` and `goal`, dicts by agent of [x, y] or [x, y, yaw], and of [x, y];
                ends that they do not have are drawn. Others as for `NavigationEnv.reset`.

        Raises:
            UsageError: the seed or an option is wrong, or there is no room for all robots. The
                environment is as before.
        """
        number, rng = require_seed(seed), self._rng
        if number is not None or rng is None:
            rng, _ = seeding.np_random(number)
        given = options_of(options)
        given.pop("options", None)  # of PettingZoo's parallel_api_test, which all environments pass
        self._navigation.reset(np.array([0]), [rng], given)
        self._rng = rng
        self._team.present[:] = True
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
        results = self._team.step(self._commands(actions))
        rewards, terminated, truncated = (self._by_agent(values[0]) for values in results)
        observations, infos = self._observations(), self._infos()
        self.agents = [self.possible_agents[row] for row in np.flatnonzero(self._team.present)]
        if self.render_mode == "human":
            self.render()
        return observations, rewards, terminated, truncated, infos

    def state(self) -> Any:
        """The state of all robots: a new array of float32, 10 numbers for each possible agent.

        They are x, y [m], cosine and sine of the yaw, velocities forwards, to the left and turning
        [m/s, m/s, rad/s], x and y of the goal [m], and 1; or zeros if its episode has ended.
        """
        return self._team.state()[0]

    def render(self) -> Any:
        """A picture: uint8, shape (480, 480, 3); None without one, or if a page shows it."""
        if self.render_mode is None or not self.agents:
            return None
        frame = self._navigation.picture(int(self._rows()[0]))
        if self._page is None:
            return frame
        self._page.show(frame)
        return None

    def close(self) -> None:
        """Ends the simulation, and closes the page."""
        self.agents = []
        self._navigation.close()
        if self._page is not None:
            self._page.close()

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

    def _observations(self) -> Dict[str, Any]:
        flat = self._navigation.observe()
        return {
            agent: self._navigation.formed(flat[row])
            for agent, row in zip(self.agents, self._rows())
        }

    def _infos(self) -> Dict[str, Any]:
        infos = self._navigation.info()
        return {agent: row_of(infos, row) for agent, row in zip(self.agents, self._rows())}

"""Several robots in one world that see and hit each other: PettingZoo's ParallelEnv."""

from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np
from gymnasium.utils import seeding

from flatland2d import BatchObservation, MissingPackageError, UsageError
from flatland_gym.episodes import EpisodeSampler
from flatland_gym.navigation import checked_actions, judge, observation_space, require_tries
from flatland_gym.navigation_world import NavigationWorld, parking_place
from flatland_gym.observations import as_dict, goal_distances, observe
from flatland_gym.pictures import check_render_mode, picture
from flatland_gym.rewards import Transition
from flatland_gym.robot_rows import RobotRows
from flatland_gym.robot_simulation import RobotSimulation
from flatland_gym.settings import NavigationSettings, is_whole, require_seed
from flatland_server import FloatArray

try:
    from pettingzoo import ParallelEnv
except ImportError:
    raise MissingPackageError(
        "flatland_gym.multi_robot_env needs PettingZoo: pip install 'flatland2d[gym]'"
    ) from None


class MultiRobotEnv(ParallelEnv[str, Any, Any]):
    """Robots in one world that each drive to a goal of their own, past each other.

    Observations, actions and rewards of each are those of `NavigationEnv`. A robot leaves
    the world when its episode has ended. The agents are called robot_0, robot_1 ... after the
    world's robot.

    Args:
        robots: how many there are, two at least: each one like the world's robot.
        render_mode: None, or "rgb_array": the surroundings of the first robot that is there.
        arguments: the attributes of `NavigationSettings`.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    def __init__(
        self, robots: int = 2, render_mode: Optional[str] = None, **arguments: Any
    ) -> None:
        if not (is_whole(robots) and robots >= 2):
            raise UsageError(f"expected robots to be a whole number of 2 or more, found {robots!r}")
        check_render_mode(render_mode, ("rgb_array",))
        settings = self._settings = NavigationSettings.of(arguments)
        if len(settings.worlds) != 1 or len(settings.robot_scales) != 1:
            raise UsageError("expected one world and one of robot_scales, found several")
        scale = settings.robot_scales[0]
        self._world = NavigationWorld.load(settings.worlds[0], settings, scale, int(robots))
        self._robot = self._world.robot
        self.metadata = {
            "name": "flatland_navigation_v0",
            "render_modes": ["rgb_array"],
            "render_fps": round(1.0 / settings.period, 3),
            "is_parallelizable": True,
        }
        self.render_mode = render_mode
        self.possible_agents = list(self._world.robots)
        self.agents: List[str] = []
        self._sampler = EpisodeSampler([self._world], settings)
        self._rng: Optional[np.random.Generator] = None
        self._simulation = RobotSimulation(self._world, settings)
        self._rows = RobotRows(BatchObservation.empty(len(self.possible_agents), self._robot.beams))
        self._goals = np.zeros((len(self.possible_agents), 2))
        self._distances = np.zeros(len(self.possible_agents))
        self._steps = 0
        space, limits = observation_space(self._robot, settings), self._robot.action_space()
        self.observation_spaces = dict.fromkeys(self.possible_agents, space)
        self.action_spaces = {agent: _copy(limits) for agent in self.possible_agents}

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
        episode = self._sampler.draw(self._rng)
        self.agents = list(self.possible_agents)
        self._simulation.begin(episode)
        tries = 1
        while self._simulation.is_blocked(episode):
            require_tries(tries)
            tries += 1
            episode = self._sampler.draw(self._rng)
            self._simulation.begin(episode)
        self._goals[:] = episode.goals
        self._rows.collided[:] = False
        self._steps = 0
        self._look()
        self._distances = goal_distances(self._rows.poses, self._goals)
        successes = np.zeros(len(self.possible_agents), dtype=bool)
        return self._observations(self.agents), self._infos(self.agents, successes)

    def step(
        self, actions: Mapping[str, Any]
    ) -> Tuple[Dict[str, Any], Dict[str, float], Dict[str, bool], Dict[str, bool], Dict[str, Any]]:
        """Drives all robots that are there for `frame_skip` steps.

        Args:
            actions: of each agent in `agents`.

        Raises:
            UsageError: an action is missing, or is not usable. The environment is as before.
        """
        agents = list(self.agents)
        commands = self._commands(actions, agents)
        for number in self._numbers(agents):
            self._simulation.command(number, commands[number].tolist())
        self._rows.collided[:] = self._simulation.step(self._settings.frame_skip)
        self._look()
        self._steps += 1
        distances = goal_distances(self._rows.poses, self._goals)
        successes = (distances < self._settings.goal_radius) & ~self._rows.collided
        rewards, terminated = judge(
            self._transition(distances, successes, commands), self._settings
        )
        self._distances = distances
        is_late = self._steps >= self._settings.longest_episode
        truncated = ~terminated & is_late
        results = (
            self._observations(agents),
            _by_agent(self, agents, rewards),
            _by_agent(self, agents, terminated),
            _by_agent(self, agents, truncated),
            self._infos(agents, successes),
        )
        for agent, number in zip(agents, self._numbers(agents)):
            if terminated[number] or truncated[number]:
                self.agents.remove(agent)
                self._simulation.remove(number, parking_place(-1 - number))
        return results

    def render(self) -> Any:
        """A picture: uint8, shape (480, 480, 3); None without a render mode."""
        if self.render_mode is None or not self.agents:
            return None
        first = self.agents[0]
        x, y = self._goals[self.possible_agents.index(first)].tolist()
        return picture(self._simulation.simulation, first, (x, y), self._settings.goal_radius)

    def close(self) -> None:
        """Ends the simulation."""
        self.agents = []
        self._simulation.close()

    def _numbers(self, agents: List[str]) -> List[int]:
        return [self.possible_agents.index(agent) for agent in agents]

    def _commands(self, actions: Mapping[str, Any], agents: List[str]) -> FloatArray:
        """The actions of all robots; zeros for robots that have left."""
        if not isinstance(actions, Mapping):
            raise UsageError(f"expected a dict of actions by agent, found {actions!r:.80}")
        if set(actions) != set(agents):
            raise UsageError(
                f"expected the actions of {', '.join(agents) or 'no agents'}; "
                f"found those of {', '.join(map(str, actions)) or 'none'}"
            )
        limits = self._robot.actions
        commands = np.zeros((len(self.possible_agents), len(limits)))
        for agent, number in zip(agents, self._numbers(agents)):
            commands[number] = checked_actions(actions[agent], limits.shape, limits)
        return commands

    def _transition(self, distances: Any, successes: Any, commands: FloatArray) -> Transition:
        rows = self._rows
        return Transition(
            self._distances,
            distances,
            successes,
            rows.collided,
            commands,
            rows.poses,
            rows.velocities,
            self._goals,
            rows.ranges,
            self._settings.period,
        )

    def _look(self) -> None:
        for number in self._numbers(self.agents):
            self._simulation.look(self._rows, number, number)

    def _observations(self, agents: List[str]) -> Dict[str, Any]:
        rows, robot = self._rows, self._robot
        limits = np.array(robot.velocity_limits)
        flat = observe(
            rows.ranges, rows.poses, rows.velocities, self._goals, robot.max_range, limits
        )
        if self._settings.flatten:
            return {agent: flat[n].copy() for agent, n in zip(agents, self._numbers(agents))}
        return {
            agent: as_dict(flat[number], robot.beams)
            for agent, number in zip(agents, self._numbers(agents))
        }

    def _infos(self, agents: List[str], successes: Any) -> Dict[str, Any]:
        return {
            agent: {
                "success": bool(successes[number]),
                "collision": bool(self._rows.collided[number]),
                "distance": float(self._distances[number]),
                "pose": self._rows.poses[number].copy(),
                "goal": self._goals[number].copy(),
            }
            for agent, number in zip(agents, self._numbers(agents))
        }


def _by_agent(env: MultiRobotEnv, agents: List[str], values: Any) -> Dict[str, Any]:
    return {agent: values[env.possible_agents.index(agent)].item() for agent in agents}


def _copy(space: Any) -> Any:
    """A space of its own for each agent, so that each has its own seed."""
    return type(space)(space.low, space.high, dtype=space.dtype)

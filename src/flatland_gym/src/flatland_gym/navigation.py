"""Navigation to goals, for n environments at a time: the common part of both kinds of environments.

Environment k is the same whatever n is: it has random numbers of its own, a simulation of its own,
and a row of its own in each array.
"""

from itertools import product
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

import numpy as np
from gymnasium import spaces

from flatland2d import UsageError
from flatland_gym.episodes import EpisodeSampler
from flatland_gym.fleet import Fleet, SimulationFleet
from flatland_gym.multi_world_fleet import make_fleet
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.observations import as_dict, bounds, goal_distances, observe
from flatland_gym.rewards import Transition, navigation_reward, navigation_termination
from flatland_gym.robot import Robot
from flatland_gym.settings import NavigationSettings
from flatland_server import BoolArray, Float32Array, FloatArray, IntArray

Steps = Tuple[FloatArray, BoolArray, BoolArray]
"""Rewards, terminations and truncations."""

_TRIES = 100


class Navigation:
    """Robots that are driven to goals, one in each of n environments.

    Args:
        settings: what the environments are.
        count: how many there are, n.
        threads: how many are stepped at a time; results do not depend on it.
        in_python: whether each has a `Simulation`, also where a batch would do. Results do not
            depend on it.

    Attributes:
        robot: the robot of every world.
        action_space: of one environment.
        observation_space: of one environment.
        goals: x, y [m] in the world, shape (n, 2).
        distances: of the robots from their goals [m], shape (n,).
        successes: whether the last step has reached the goal, shape (n,).
        steps: of the present episodes, shape (n,).

    Raises:
        FlatlandError: a world cannot be used.
    """

    def __init__(
        self,
        settings: NavigationSettings,
        count: int,
        threads: int = 1,
        *,
        in_python: bool = False,
    ) -> None:
        self.settings = settings
        self._worlds = [
            NavigationWorld.load(world, settings, scale)
            for world, scale in product(settings.worlds, settings.robot_scales)
        ]
        self.robot = self._worlds[0].robot
        for world in self._worlds[1:]:
            _require_alike(self._worlds[0], world)
        self._sampler = EpisodeSampler(self._worlds, settings)
        new_fleet = SimulationFleet if in_python else make_fleet
        self.fleet: Fleet = new_fleet(self._worlds, settings, count, threads)
        self.action_space = self.robot.action_space()
        self.observation_space = observation_space(self.robot, settings)
        self._limits = self.robot.actions
        self._velocity_limits = np.array(self.robot.velocity_limits)
        self.world_of = np.zeros(count, dtype=int)
        self.goals = np.zeros((count, 2))
        self.distances = np.zeros(count)
        self.successes = np.zeros(count, dtype=bool)
        self.steps = np.zeros(count, dtype=int)

    def reset(
        self,
        indices: IntArray,
        generators: Sequence[np.random.Generator],
        options: Optional[Mapping[str, Any]] = None,
    ) -> None:
        """Begins an episode in each of these environments.

        Args:
            indices: of the environments.
            generators: the random numbers of each.
            options: see `EpisodeSampler.draw`.

        Raises:
            UsageError: an option is wrong. The environments are as before.
        """
        states = [generator.bit_generator.state for generator in generators] if options else []
        try:
            episodes = [self._sampler.draw(generator, options) for generator in generators]
        except UsageError:
            for generator, state in zip(generators, states):
                generator.bit_generator.state = state
            raise
        self.fleet.reset(indices, episodes)
        for number, index in enumerate(indices.tolist()):
            tries = 1
            while self.fleet.is_blocked(index, episodes[number]):
                require_tries(tries)
                tries += 1
                episodes[number] = self._sampler.draw(generators[number], options)
                self.fleet.reset(np.array([index]), [episodes[number]])
        self.goals[indices] = [episode.goals[0] for episode in episodes]
        self.world_of[indices] = [episode.world for episode in episodes]
        self.steps[indices] = 0
        self.successes[indices] = False
        distances = goal_distances(self.fleet.poses, self.goals)
        self.distances[indices] = distances[indices]

    def step(self, actions: FloatArray, indices: IntArray) -> Steps:
        """Makes a step in each of these environments.

        Args:
            actions: of all environments, as `checked_actions` returns them.
            indices: of the environments, in increasing order.

        Returns:
            New arrays of n rows; those of other environments are 0 and False.
        """
        fleet, settings = self.fleet, self.settings
        fleet.step(actions, indices)
        self.steps[indices] += 1
        distances = goal_distances(fleet.poses, self.goals)
        successes = (distances < settings.goal_radius) & ~fleet.collided
        transition = Transition(
            self.distances,
            distances,
            successes,
            fleet.collided,
            actions,
            fleet.poses,
            fleet.velocities,
            self.goals,
            fleet.ranges,
            settings.period,
        )
        rewards, terminated = judge(transition, settings)
        rows = np.zeros(len(distances), dtype=bool)
        rows[indices] = True
        truncated = rows & ~terminated & (self.steps >= settings.longest_episode)
        self.distances = np.where(rows, distances, self.distances)
        self.successes = np.where(rows, successes, self.successes)
        return np.where(rows, rewards, 0.0), terminated & rows, truncated

    def observe(self) -> Float32Array:
        """Flat observations of all environments: a new array."""
        return observe(
            self.fleet.ranges,
            self.fleet.poses,
            self.fleet.velocities,
            self.goals,
            self.robot.max_range,
            self._velocity_limits,
        )

    def formed(self, observations: Float32Array) -> Any:
        """Observations in the form of the settings: flat, or as a dict."""
        return observations if self.settings.flatten else as_dict(observations, self.robot.beams)

    def info(self) -> Dict[str, Any]:
        """The entries of infos, for all environments: new arrays."""
        return {
            "success": self.successes.copy(),
            "collision": self.fleet.collided.copy(),
            "distance": self.distances.copy(),
            "pose": self.fleet.poses.copy(),
            "goal": self.goals.copy(),
        }

    def checked_actions(self, actions: Any, shape: Tuple[int, ...]) -> FloatArray:
        """Actions as float64, cut to the limits.

        Raises:
            UsageError: they have another shape, are no numbers, or are not finite.
        """
        return checked_actions(actions, shape, self._limits)

    def close(self) -> None:
        """Ends all simulations."""
        self.fleet.close()


def require_tries(count: int) -> None:
    """Raises a UsageError after too many tries to begin an episode."""
    if count >= _TRIES:
        raise UsageError(
            "the start or the goal lies in walls that a plugin of the world has added (tried "
            f"{_TRIES} times)"
        )


def judge(transition: Transition, settings: NavigationSettings) -> Tuple[FloatArray, BoolArray]:
    """Rewards and terminations of n environments, by the settings' functions if there are any.

    Raises:
        UsageError: such a function has returned another shape, or no finite numbers.
    """
    count = len(transition.distance)
    arrays = {name: _frozen(getattr(transition, name)) for name in Transition._fields[:-1]}
    step = transition._replace(**arrays)
    if settings.reward is None:
        rewards = navigation_reward(step, settings.rewards)
    else:
        rewards = _result("reward", settings.reward(step), np.float64, count)
    if settings.terminated is None:
        terminated = navigation_termination(step, settings.collision_ends)
    else:
        terminated = _result("terminated", settings.terminated(step), np.bool_, count)
    return rewards, terminated


def observation_space(robot: Robot, settings: NavigationSettings) -> "spaces.Space[Any]":
    """The space of a robot's observations; see `observations`."""
    low, high = bounds(robot.beams, sum(limit > 0.0 for limit in robot.velocity_limits))
    if settings.flatten:
        ends = [np.concatenate(list(each.values())) for each in (low, high)]
        return spaces.Box(ends[0], ends[1], dtype=np.float32)
    return spaces.Dict({key: spaces.Box(low[key], high[key], dtype=np.float32) for key in low})


def checked_actions(actions: Any, shape: Tuple[int, ...], limits: FloatArray) -> FloatArray:
    """Actions as float64, cut to their limits; see `Navigation.checked_actions`."""
    try:
        found = np.asarray(actions)
    except (TypeError, ValueError) as error:
        raise UsageError(f"expected actions of numbers, found {actions!r:.80}: {error}") from None
    if found.dtype.kind not in "fiu":
        raise UsageError(f"expected actions of numbers, found {found.dtype} in {actions!r:.80}")
    if found.shape != shape:
        raise UsageError(f"expected actions of shape {shape}, found {found.shape}")
    values = found.astype(np.float64)
    if not np.isfinite(values).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
        raise UsageError(f"expected finite actions, found {values[place]} at {place}")
    clipped: FloatArray = np.clip(values, -limits, limits)
    return clipped


def _require_alike(first: NavigationWorld, other: NavigationWorld) -> None:
    """Raises a UsageError unless the robots of two worlds have the same spaces."""
    for name in ("beams", "max_range", "action_limits", "velocity_limits"):
        a, b = getattr(first.robot, name), getattr(other.robot, name)
        if a != b:
            raise UsageError(
                f"expected worlds in which the robots are alike: {name} is {a} in {first.name}, "
                f"{b} in {other.name}"
            )


def _frozen(array: Any) -> Any:
    """A read-only view."""
    view = array.view()
    view.flags.writeable = False
    return view


def _result(name: str, value: Any, kind: Any, count: int) -> Any:
    """The checked result of a user's function, as an array of n values."""
    result = np.asarray(value)
    if result.shape != (count,):
        raise UsageError(f"expected {name} to return shape ({count},), found {result.shape}")
    if result.dtype.kind not in "biuf" or not np.isfinite(result).all():
        raise UsageError(f"expected {name} to return finite numbers, found {result!r:.80}")
    return result.astype(kind)

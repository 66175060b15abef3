"""Navigation to goals, for n robots at a time: the common part of all environments.

Environment k is the same whatever n is: it has random numbers of its own, a simulation of its own,
and a row of its own in each array.
"""

from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from flatland2d import BatchObservation, Simulation, UsageError
from flatland_gym.episodes import EpisodeSampler, options_of
from flatland_gym.fleet import Fleet, Motions, make_fleet
from flatland_gym.maps import Maps
from flatland_gym.navigation_world import load_all
from flatland_gym.neighbors import Neighbors
from flatland_gym.observations import STANDARD, goal_distances
from flatland_gym.parts import Known, Parts, Situation, parts_of
from flatland_gym.pictures import RENDER_MODES, picture, status_line
from flatland_gym.policy import Policy
from flatland_gym.reward_functions import evaluate_step, frozen
from flatland_gym.rewards import OtherModels, Transition
from flatland_gym.settings import NavigationSettings
from flatland_server import BoolArray, Float32Array, FloatArray, IntArray, Segments
from flatland_server._core import GoalObserver

Steps = Tuple[FloatArray, BoolArray, BoolArray]
"""Rewards, terminations and truncations."""

_TRIES = 100


class Navigation:
    """Robots that are driven to goals, one or m in each of n environments.

    Arrays have a row for each robot, those of the first environment first.

    Episodes in different worlds run in different fleets, made when they are first needed; all
    write to the same rows.

    Args:
        settings: settings of the environments.
        count: number of environments, n.
        threads: how many are stepped at a time; results do not depend on it.
        robots: how many each environment has, m.

    Attributes:
        metadata: Gymnasium's, of these environments.
        robot: the robot of every world.
        robot_names: the models of the robots in the first world.
        action_space: of one robot.
        observation_space: of one robot.
        rows: what the robots measure.
        goals: x, y [m] in the world, shape (n * m, 2).
        distances: of the robots from their goals [m], shape (n * m,).
        successes: whether the last step has reached the goal, shape (n * m,).
        steps: of the present episodes, shape (n * m,).

    Raises:
        FlatlandError: a world cannot be used.
    """

    def __init__(
        self,
        settings: NavigationSettings,
        count: int = 1,
        threads: int = 1,
        robots: int = 1,
    ) -> None:
        self.settings = settings
        self.metadata: Dict[str, Any] = {
            "render_modes": list(RENDER_MODES),
            "render_fps": round(1.0 / settings.period, 3),
        }
        self._worlds = load_all(settings, robots)
        self.robot, self.robot_names = self._worlds[0].robot, self._worlds[0].robots
        self._others = tuple(dict.fromkeys(n for world in self._worlds for n in world.others))
        self._radii = np.array([world.radii(self._others) for world in self._worlds])
        self._maps = Maps(settings, self._worlds[0], count) if settings.maps is not None else None
        self._sampler = EpisodeSampler(self._worlds, settings, self._maps, count)
        self.options = {}
        self._fleets: Dict[int, Fleet] = {}
        self._threads = threads
        self.action_space = self.robot.action_space()
        self._is_standard = settings.observation is None
        standard = STANDARD if settings.neighbors else STANDARD[:-1]
        self._parts = self._parts_of(standard if self._is_standard else settings.observation)
        self._privileged = None
        if settings.privileged is not None:
            self._privileged = self._parts_of(settings.privileged)
        parts = self._parts
        self.observation_space = parts.flat_space if settings.flatten else parts.dict_space
        self._limits = self.robot.actions
        self._observer = GoalObserver(
            self.robot.beams, self.robot.max_range, self.robot.velocity_limits
        )
        self._period, self._longest_episode = settings.period, settings.longest_episode
        self._team = robots
        count *= self._team
        self.rows = BatchObservation.empty(count, self.robot.beams)
        self._neighbors = Neighbors(self._worlds, settings, count, self._team, self._maps)
        self._world_of = np.full(count, -1)  # the index of each row's world
        self._map_of = np.zeros(count, int)
        self._vary = np.zeros((count, len(settings.vary)))
        self.goals = np.zeros((count, 2))
        self.distances = np.zeros(count)
        self.successes = np.zeros(count, dtype=bool)
        self.steps = np.zeros(count, dtype=int)
        if settings.vary:  # which only a fleet checks
            self._fleet(0)

    @property
    def options(self) -> Dict[str, Any]:
        """Options of all resets from now on, also of automatic ones; a new dict."""
        return dict(self._options)

    @options.setter
    def options(self, options: Optional[Mapping[str, Any]]) -> None:
        found = options_of(options)
        self._choices = self._sampler.choices(found)
        self._options: Dict[str, Any] = found

    def reset(
        self,
        indices: IntArray,
        generators: Sequence[np.random.Generator],
        options: Optional[Mapping[str, Any]] = None,
    ) -> None:
        """Begins an episode in each of these environments.

        Args:
            indices: indices of the environments to reset.
            generators: random number generator of each of them.
            options: see `EpisodeSampler.choices`; those in `options` apply where these have none.

        Raises:
            UsageError: an option is wrong. The environments are as before.
        """
        given, choices = options_of(options), self._choices
        if given:
            choices = self._sampler.choices({**self._options, **given})
        own = [choices[k % len(choices)] for k in indices.tolist()]
        may_fail = given or self._options or self._maps is not None
        states = [generator.bit_generator.state for generator in generators] if may_fail else []
        try:
            episodes = [self._sampler.draw(*each) for each in zip(generators, own)]
        except BaseException:  # also one of a program's function that makes maps
            for generator, state in zip(generators, states):
                generator.bit_generator.state = state
            raise
        for world in sorted({episode.world for episode in episodes}):
            chosen = [k for k, episode in enumerate(episodes) if episode.world == world]
            self._fleet(world).reset(indices[chosen], [episodes[k] for k in chosen])
        for number, index in enumerate(indices.tolist()):
            tries = 1
            while self._fleet(episodes[number].world).is_blocked(index, episodes[number]):
                if tries >= _TRIES:
                    raise UsageError(
                        "the start or the goal lies in walls that a plugin of the world has added "
                        f"(tried {_TRIES} times)"
                    )
                tries += 1
                episode = episodes[number] = self._sampler.draw(generators[number], own[number])
                self._fleet(episode.world).reset(np.array([index]), [episode])
        rows = indices
        if self._team > 1:
            rows = self._rows_of(indices).ravel()
        self.goals[rows] = [goal for episode in episodes for goal in episode.goals]
        self._world_of[rows] = [episode.world for episode in episodes for _ in episode.goals]
        if self._maps is not None:
            self._map_of[rows] = [episode.map for episode in episodes for _ in episode.goals]
        if self.settings.vary:
            self._vary[rows] = [
                list(episode.vary.values()) for episode in episodes for _ in episode.goals
            ]
        if self.settings.neighbors:
            self._see(indices, [episode.seed for episode in episodes])
        self.steps[rows] = 0
        self.successes[rows] = False
        self.distances[rows] = goal_distances(self.rows.poses[rows], self.goals[rows])

    def step(self, actions: FloatArray, indices: IntArray) -> Steps:
        """Makes a step with each of these robots.

        Args:
            actions: of all robots, as `checked_actions` returns them.
            indices: rows of the robots in the arrays, in increasing order.

        Returns:
            New arrays of all rows; those of other robots are 0 and False.
        """
        state, settings = self.rows, self.settings
        if len(self._worlds) == 1:
            self._fleet(0).step(actions, indices)
        else:
            worlds = self._world_of[indices]
            for world, fleet in self._fleets.items():
                chosen = indices[worlds == world]
                if len(chosen):
                    fleet.step(actions, chosen)
        self.steps[indices] += 1
        distances = goal_distances(state.poses, self.goals)
        successes = (distances < settings.goal_radius) & ~state.collided
        rewards, terminated = self._evaluate(distances, successes, actions, indices)
        if len(indices) == len(distances):  # quicker than with a mask
            self.distances, self.successes = distances, successes
            return rewards, terminated.copy(), ~terminated & (self.steps >= self._longest_episode)
        rows = np.zeros(len(distances), dtype=bool)
        rows[indices] = True
        truncated = rows & ~terminated & (self.steps >= self._longest_episode)
        self.distances = np.where(rows, distances, self.distances)
        self.successes = np.where(rows, successes, self.successes)
        return np.where(rows, rewards, 0.0), terminated & rows, truncated

    def _evaluate(
        self, distances: FloatArray, successes: BoolArray, actions: FloatArray, indices: IntArray
    ) -> Tuple[FloatArray, BoolArray]:
        """Rewards and terminations of a step of these rows."""
        state = self.rows
        transition = Transition(
            self.distances,
            distances,
            successes,
            state.collided,
            actions,
            state.poses,
            state.local_velocities,
            self.goals,
            state.ranges,
            self._period,
            self._models(indices),
        )
        return evaluate_step(transition, self.settings)

    def retire(self, indices: IntArray, leaving: BoolArray) -> None:
        """Stops robots after the ends of their episodes, in environments in which others go on.

        Args:
            indices: rows of the robots in the arrays.
            leaving: those that are taken out of their world, (n * m,).
        """
        for world, fleet in self._fleets.items():
            fleet.retire(indices[self._world_of[indices] == world], leaving)

    def _models(self, indices: IntArray) -> OtherModels:
        """The other models in these rows."""
        return OtherModels(self._others, lambda: self._motions(indices))

    def _motions(self, indices: IntArray) -> Motions:
        """Poses and velocities of other models in these rows; NaN elsewhere: (n, m, 3) each."""
        shape = (len(self.goals), len(self._others), 3)
        poses, velocities = np.full(shape, np.nan), np.full(shape, np.nan)
        for world, fleet in self._fleets.items():
            chosen = indices[self._world_of[indices] == world]
            if len(chosen):
                columns = [self._others.index(name) for name in self._worlds[world].others]
                place = np.ix_(chosen, columns)
                poses[place], velocities[place] = fleet.motions(chosen)
        return poses, velocities

    def save_states(self, indices: IntArray) -> List[Dict[str, Any]]:
        """The states of environments with their episodes, as plain data."""
        rows = self._rows_of(indices)
        states: Dict[int, bytes] = {}
        for world in np.unique(self._world_of[rows]).tolist():
            chosen = indices[self._world_of[rows[:, 0]] == world]
            states.update(zip(chosen.tolist(), self._fleet(world).save_states(chosen)))
        return [
            {
                "world": int(self._world_of[own[0]]),
                "simulation": states[k],
                "goal": self.goals[own].tolist(),
                "distance": self.distances[own].tolist(),
                "success": self.successes[own].tolist(),
                "collided": self.rows.collided[own].tolist(),
                "steps": self.steps[own].tolist(),
                "episode": int(self._neighbors.seeds[own[0]]),
                "map": int(self._map_of[own[0]]),
                "vary": self._vary[own[0]].tolist(),
            }
            for k, own in zip(indices.tolist(), rows)
        ]

    def load_states(self, indices: IntArray, states: Sequence[Mapping[str, Any]]) -> None:
        """Puts environments into states, and their episodes.

        Args:
            indices: indices of the environments.
            states: results of `save_states`, one for each.

        Raises:
            FlatlandError: a state does not fit.
        """
        worlds = np.array([state["world"] for state in states], dtype=int)
        if not ((worlds >= 0) & (worlds < len(self._worlds))).all():
            raise UsageError("the state is of an environment with more worlds")
        robots = {len(state["goal"]) for state in states}
        if robots != {self._team}:
            raise UsageError(f"expected states with {self._team} robots, found {max(robots)}")
        for world in np.unique(worlds).tolist():
            chosen = np.flatnonzero(worlds == world).tolist()
            loaded = [states[k]["simulation"] for k in chosen]
            self._fleet(world).load_states(indices[chosen], loaded)
        rows = self._rows_of(indices)
        self._world_of[rows] = worlds[:, None]
        self._map_of[rows] = [[state["map"]] for state in states]
        self._vary[rows] = [[state["vary"]] for state in states]
        self.goals[rows] = [state["goal"] for state in states]
        self.distances[rows] = [state["distance"] for state in states]
        self.successes[rows] = [state["success"] for state in states]
        self.rows.collided[rows] = [state["collided"] for state in states]
        self.steps[rows] = [state["steps"] for state in states]
        self._see(indices, [state["episode"] for state in states])

    def _rows_of(self, indices: IntArray) -> IntArray:
        """The rows of the robots of environments: (k, m)."""
        return self._team * indices[:, None] + np.arange(self._team)

    def _see(self, indices: IntArray, seeds: Sequence[int]) -> None:
        """Prepares the observation of neighbours in environments with episodes of these seeds."""
        for rows, seed in zip(self._rows_of(indices), seeds):
            self._neighbors.seeds[rows] = seed
            fleet = self._fleet(int(self._world_of[rows[0]]))
            self._neighbors.add_walls(rows.tolist(), fleet.added_walls(rows[0] // self._team))

    @property
    def _walls_of(self) -> IntArray:
        """The number of each row's map, or the index of its world."""
        return self._world_of if self._maps is None else self._map_of

    def observe(self) -> Float32Array:
        """Flat observations of all robots: a new array."""
        return self._standard() if self._is_standard else self._parts.flat(self._known())

    def privileged(self) -> Float32Array:
        """The parts in the setting `privileged`, of all robots: a new array."""
        assert self._privileged is not None
        return self._privileged.flat(self._known())

    def _parts_of(self, setting: Any) -> Parts:
        velocities = sum(limit > 0.0 for limit in self.robot.velocity_limits)
        sizes = self.robot.beams, velocities, self.settings.neighbors
        return Parts(parts_of(setting), *sizes, self._walls_at, self._others)

    def _walls_at(self, place: int) -> Segments:
        """The walls of a number in `_walls_of`."""
        return (self._worlds[place] if self._maps is None else self._maps[place].world).walls

    def _known(self) -> Known:
        rows = self.rows
        situation = Situation(
            frozen(rows.poses),
            frozen(rows.local_velocities),
            frozen(self.goals),
            frozen(rows.ranges),
            self._models(np.arange(len(self.goals))),
        )
        return Known(situation, self._standard(), self._radii[self._world_of], self._walls_of)

    def _standard(self) -> Float32Array:
        """Ranges, goal, velocity and neighbours of all robots: a new array."""
        rows = self.rows
        flat = self._observer.observe(rows.ranges, rows.poses, rows.local_velocities, self.goals)
        if not self.settings.neighbors:
            return flat
        poses, velocities = self._motions(np.arange(len(flat)))
        radii = self._radii[self._world_of][..., None]
        others = np.concatenate([poses[..., :2], velocities[..., :2], radii], axis=-1)
        near = self._neighbors.observe(
            rows.poses, rows.local_velocities, others, self._walls_of, self.steps
        )
        return np.concatenate([flat, near], axis=1)

    def formed(self, observations: Float32Array) -> Any:
        """Observations in the form of the settings: flat, or as a dict."""
        return observations if self.settings.flatten else self._parts.as_dict(observations)

    def info(self) -> Dict[str, Any]:
        """The entries of infos, for all robots: new arrays."""
        found: Dict[str, Any] = {
            "success": self.successes.copy(),
            "collision": self.rows.collided.copy(),
            "distance": self.distances.copy(),
            "pose": self.rows.poses.copy(),
            "goal": self.goals.copy(),
        }
        if self._maps is not None:
            found["map"] = self._map_of.copy()
        if self.settings.vary:
            found["vary"] = self._vary.copy()
        if self._privileged is not None:
            found["privileged"] = self.privileged()
        return found

    def policy(self, weights: Sequence[Float32Array], biases: Sequence[Float32Array]) -> Policy:
        """A policy for the robot: a network with these layers.

        Raises:
            UsageError: its observations are of a user's own parts, which no robot makes.
        """
        self.require_standard()
        robot = self.robot
        return Policy(
            tuple(weights),
            tuple(biases),
            robot.beams,
            robot.max_range,
            robot.velocity_limits,
            robot.action_limits,
            self._period,
            self.settings.neighbors,
            self._neighbors.reach,
            bool(self.settings.neighbors_behind_walls),
        )

    def require_standard(self) -> None:
        """Raises a UsageError if observations are of a user's own parts."""
        if not self._is_standard:
            raise UsageError(
                "a policy of flatland_gym observes ranges, goal, velocity and neighbours: expected "
                "no argument observation"
            )

    def simulation(self, index: int) -> Simulation:
        """The simulation that has the robot of a row, or shows it."""
        return self._fleet(int(self._world_of[index])).simulation(index // self._team)

    def picture(self, index: int) -> Any:
        """The picture of the robot of a row."""
        names = self._worlds[self._world_of[index]].robots
        return picture(
            self.simulation(index),
            names[index % len(names)],
            tuple(self.goals[index].tolist()),
            self.settings.goal_radius,
        )

    def status(self, index: int) -> str:
        """The state of a row in a line of text."""
        return status_line(
            float(self.steps[index]) * self._period,
            self.rows.poses[index],
            self.goals[index],
            float(self.distances[index]),
        )

    def close(self) -> None:
        """Ends all simulations."""
        for fleet in self._fleets.values():
            fleet.close()

    def _fleet(self, world: int) -> Fleet:
        """The fleet of a world."""
        if world not in self._fleets:
            found, settings = self._worlds[world], self.settings
            self._fleets[world] = make_fleet(found, settings, self.rows, self._threads, self._maps)
        return self._fleets[world]

    def checked_actions(self, actions: Any, shape: Tuple[int, ...]) -> FloatArray:
        """Actions as float64, cut to the limits.

        Raises:
            UsageError: they have another shape, are no numbers, or are not finite.
        """
        values = numbers_of(actions, shape).astype(np.float64)
        if not np.isfinite(values).all():
            place = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
            raise UsageError(f"expected finite actions, found {values[place]} at {place}")
        clipped: FloatArray = np.minimum(np.maximum(values, -self._limits), self._limits)
        return clipped


def numbers_of(actions: Any, shape: Tuple[int, ...]) -> "np.ndarray[Any, Any]":
    """Actions as an array.

    Raises:
        UsageError: they have another shape, or are no numbers.
    """
    try:
        found = np.asarray(actions)
    except (TypeError, ValueError) as error:
        raise UsageError(f"expected actions of numbers, found {actions!r:.80}: {error}") from None
    if found.dtype.kind not in "fiu":
        raise UsageError(f"expected actions of numbers, found {found.dtype} in {actions!r:.80}")
    if found.shape != shape:
        raise UsageError(f"expected actions of shape {shape}, found {found.shape}")
    return found


def row_of(infos: Mapping[str, Any], index: int) -> Dict[str, Any]:
    """The info of one environment, from those of all."""
    return {
        name: values[index].item() if values.ndim == 1 else values[index]
        for name, values in infos.items()
    }

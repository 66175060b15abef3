"""Worlds side by side: the backends of navigation environments.

A fleet has n places, each with a simulation of the same world. It writes what the robots measure
into the arrays of a `BatchObservation`, which fleets of several worlds share. It is a `BatchFleet`,
or a `SimulationFleet` with the same methods.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from flatland2d import BatchObservation, PluginError, Simulation, SimulationBatch
from flatland2d.batch.variation import with_values
from flatland_gym.episodes import Episode
from flatland_gym.maps import Maps
from flatland_gym.navigation_world import NavigationWorld, parking_place
from flatland_gym.settings import NavigationSettings
from flatland_server import Body, BoolArray, FloatArray, IntArray, ModelPlugin, Segments
from flatland_server.simulation import WorldState

Motions = Tuple[FloatArray, FloatArray]
"""Poses and velocities."""


class BatchFleet:
    """A `SimulationBatch`: all places in one call of the core.

    It gives the same numbers as a `SimulationFleet`, bit for bit.

    Args:
        world: the world to simulate.
        settings: settings of the environment.
        rows: what the robots measure; overwritten in each step. A row for each robot, those of the
            first place first.
        threads: number of threads of the batch.
        maps: the maps of `settings`.

    Raises:
        PluginError: a plugin of the world runs in Python at each step.
    """

    def __init__(
        self,
        world: NavigationWorld,
        settings: NavigationSettings,
        rows: BatchObservation,
        threads: int = 1,
        maps: Optional[Maps] = None,
    ) -> None:
        self._world = world
        self._settings = settings
        self._room = world.radius + settings.margin
        self._maps = maps
        self._team = team = len(world.robots)
        count = len(rows.poses) // team
        self._moved = [disc.name for disc in (*world.scattered, *world.obstacles)]
        self._batch = SimulationBatch(
            world.config,
            count,
            robots=world.robots,
            lidar=world.robot.lidar,
            threads=min(threads, count),
            moved=self._moved,
            vary=settings.vary,
            step_size=settings.step_size,
            params=settings.params,
        )
        shaped = [each.reshape(count, team, *each.shape[1:]) for each in rows[:5]]
        self._out = BatchObservation._make([*shaped, np.empty(count)])  # writes to the rows
        parking = [parking_place(-1 - number) for number in range(team)]
        self._parking = np.broadcast_to(parking, self._out.poses.shape)
        self._places = np.zeros((count, len(self._moved), 3))
        self._commands = np.zeros((len(rows.poses), len(self._batch.action_names)))
        self._drive = self._batch.stepper(settings.frame_skip, self._out)
        self._restart = self._batch.restarter(self._out)
        self._is_plain = count == 1 and maps is None and not settings.vary

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        """Begins an episode at each of these places."""
        count = len(self._out.poses)
        if self._is_plain:  # the checks of a batch take longer than a reset of one
            (episode,) = episodes
            moved = [value for name in self._moved for value in episode.places[name]]
            models = np.array([moved]) if moved else None
            self._restart(np.array([episode.seed]), np.array(episode.starts), models)
            return
        seeds = np.array([episode.seed for episode in episodes])
        poses = np.array([episode.starts for episode in episodes])
        mask = places = None
        if len(indices) < count:
            mask, given = self._mask(indices), (seeds, poses)
            seeds, poses = np.zeros(count, np.int64), np.zeros(self._out.poses.shape)
            seeds[indices], poses[indices] = given
        if self._moved:
            places = self._places
            places[indices] = [[each.places[name] for name in self._moved] for each in episodes]
        walls = {}
        if self._maps is not None:
            numbers = zip(indices.tolist(), episodes)
            walls = {k: self._maps[episode.map or 0].walls for k, episode in numbers}
        vary: Dict[str, FloatArray] = {}
        if self._settings.vary:
            vary = {name: np.empty(count) for name in self._settings.vary}
            for k, episode in zip(indices.tolist(), episodes):
                for name, value in episode.vary.items():
                    vary[name][k] = value
        self._batch.reset(
            mask, seeds, poses, out=self._out, model_poses=places, walls=walls, vary=vary
        )

    def is_blocked(self, index: int, episode: Episode) -> bool:
        """True if plugins have added walls at a start or a goal of a place's episode."""
        worlds_differ = self._batch.worlds_differ
        return worlds_differ and episode.is_near(self.added_walls(index), self._room)

    def added_walls(self, index: int) -> Segments:
        """The walls that plugins have added at a place: (m, 4)."""
        return self._batch.added_walls(index)

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        """Makes a step of the environment with each of these robots.

        Args:
            actions: of all robots, shape (n, size of an action); finite.
            indices: rows of the robots in the arrays, in increasing order.
        """
        mask = None
        if len(indices) < len(actions):
            mask = np.zeros(self._out.collided.shape, bool)
            mask.ravel()[indices] = True
            self._out.collided[mask.any(axis=1)] = False  # of robots that are not observed, too
        shaped = actions.reshape(*self._out.collided.shape, -1)
        self._batch.step(shaped, self._settings.frame_skip, out=self._out, mask=mask)

    def drive(self, command: Sequence[float]) -> None:
        """Makes a step of the environment of the only robot; the command is finite."""
        self._commands[0] = command
        self._drive(self._commands)

    def retire(self, indices: IntArray, leaving: BoolArray) -> None:
        """Stops robots that `step` is no longer called with, and parks those that leave.

        Args:
            indices: rows of the robots in the arrays, in increasing order.
            leaving: the robots that leave the world, as a mask of all robots.
        """
        mask = np.zeros(self._out.collided.shape, bool)
        mask.ravel()[indices] = leaving[indices]
        if mask.any():  # the others are stopped by the next step
            self._batch.move(self._parking, mask)

    def save_states(self, indices: IntArray) -> List[bytes]:
        """The states of the simulations at these places."""
        return self._batch.save_states(self._mask(indices))

    def load_states(self, indices: IntArray, states: Sequence[bytes]) -> None:
        """Puts the simulations at these places into states of the same world."""
        self._batch.load_states(states, self._mask(indices), out=self._out)

    def _mask(self, indices: IntArray) -> BoolArray:
        mask = np.zeros(len(self._out.poses), bool)
        mask[indices] = True
        return mask

    def simulation(self, index: int) -> Simulation:
        """A simulation that shows the place: the same one for all places."""
        return self._batch.view(index)

    def motions(self, indices: IntArray) -> Motions:
        """Poses and velocities of the world's `others`, for these robots' rows: (k, m, 3) each."""
        columns = [self._batch.models.index(name) for name in self._world.others]
        poses, velocities = self._batch.model_motions()
        rows = (indices // self._team)[:, None]
        return poses[rows, columns], velocities[rows, columns]

    def close(self) -> None:
        """Ends all simulations."""
        self._batch.close()


class _Place:
    """A `Simulation` with the robots of an environment, each with a row of the arrays.

    Works with every plugin, and with models that move.
    """

    def __init__(
        self, world: NavigationWorld, settings: NavigationSettings, rows: BatchObservation
    ) -> None:
        self._world = world
        self._settings = settings
        self._rows = rows
        self._simulation: Optional[Simulation] = None  # made with the seed of the first episode
        self._values: Mapping[str, float] = {}  # of the numbers that differ between episodes

    def reset(self, episode: Episode) -> None:
        simulation = self._open(episode.seed, episode.vary)
        simulation.reset(episode.seed)
        for name, pose in (*zip(self._world.robots, episode.starts), *episode.places.items()):
            simulation.move(name, pose)
        self._begin(simulation)

    def save_state(self) -> bytes:
        state = self.simulation.save_state()
        if self._values:
            state = replace(WorldState.loads(state), vary=dict(self._values)).dumps()
        return state

    def load_state(self, state: bytes) -> None:
        values: Mapping[str, float] = {}
        if self._settings.vary:
            read = WorldState.loads(state)
            values, state = read.vary or {}, replace(read, vary=None).dumps()
        self._begin(self._open(0, values).load_state(state))

    def _open(self, seed: int, values: Mapping[str, float]) -> Simulation:
        """The simulation with these values, in any state; made with a seed if it is new."""
        if self._simulation is None or values != self._values:
            config, settings = with_values(self._world.config, values), self._settings
            self.close()
            self._simulation = Simulation(
                config, seed=seed, step_size=settings.step_size, params=settings.params
            )
            self._values = values
        return self._simulation

    def _begin(self, simulation: Simulation) -> None:
        """Looks up the robots, which are new objects, and what they measure."""
        world = self._world
        self._numbers = {name: number for number, name in enumerate(world.robots)}
        self._physics = simulation.world.physics
        robots = [simulation.models[name] for name in world.robots]
        self._bodies: List[Body] = [robot.model.base.physics_body for robot in robots]
        self._drives: List[ModelPlugin] = [robot.plugin(world.robot.drive) for robot in robots]
        self._lidars: List[ModelPlugin] = [robot.plugin(world.robot.lidar) for robot in robots]
        rows = self._rows
        self._views = list(zip(rows.ranges, rows.poses, rows.local_velocities))
        rows.collided[:] = False
        self._look(range(len(robots)))

    def added_walls(self) -> Segments:
        config = self._world.config
        added = [
            layer.segments[len(config.walls_of(layer.config)) :]
            for layer in self.simulation.world.layers
        ]
        return np.concatenate([np.empty((0, 4)), *added])

    def step(self, numbers: Sequence[int], commands: Sequence[Sequence[float]]) -> None:
        """Makes a step of the environment with some robots.

        Args:
            numbers: rows of the robots in the arrays.
            commands: the actions of these robots; finite.
        """
        simulation, collided = self.simulation, self._rows.collided
        for number, command in zip(numbers, commands):
            self._drives[number].command(*command)
        collided[:] = False
        for _ in range(self._settings.frame_skip):
            simulation.step()
            if not self._physics.touches:  # in most steps; quicker than `contacts`
                continue
            for touch in simulation.contacts:
                if touch.points and touch.model_a != touch.model_b:
                    for name in (touch.model_a, touch.model_b):
                        if name in self._numbers:
                            collided[self._numbers[name]] = True
        self._look(numbers)

    def retire(self, numbers: Sequence[int], leaving: BoolArray) -> None:
        zeros = [0.0] * len(self._world.robot.action_limits)
        for number in numbers:
            self._drives[number].command(*zeros)
            if leaving[number]:
                self.simulation.move(self._world.robots[number], parking_place(-1 - number))

    @property
    def simulation(self) -> Simulation:
        assert self._simulation is not None  # there is one from the first episode on
        return self._simulation

    def motions(self) -> Motions:
        names = list(self.simulation.models)
        columns = [names.index(name) for name in self._world.others]
        return self.simulation.poses[columns], self.simulation.velocities[columns]

    def close(self) -> None:
        if self._simulation is not None:
            self._simulation.close()

    def _look(self, numbers: Sequence[int]) -> None:
        """Writes the measurements of some robots."""
        timekeeper = self.simulation.timekeeper
        for number in numbers:
            ranges, pose, velocity = self._views[number]
            ranges[:] = self._lidars[number].read(timekeeper)
            self._bodies[number].read_motion(pose, velocity)


class SimulationFleet:
    """A `Simulation` at each place, made when it is first needed; methods as of a `BatchFleet`.

    Args:
        world: the world to simulate.
        settings: settings of the environment.
        rows: arrays for the measurements of the robots.
        threads: how many places are stepped at a time.
    """

    def __init__(
        self,
        world: NavigationWorld,
        settings: NavigationSettings,
        rows: BatchObservation,
        threads: int = 1,
    ) -> None:
        self._world = world
        self._settings = settings
        self._rows = rows
        self._room = world.radius + settings.margin
        self._team = len(world.robots)
        self._places: Dict[int, _Place] = {}
        self._threads = min(threads, len(rows.poses) // self._team)
        self._pool: Optional[ThreadPoolExecutor] = None
        if self._threads > 1:
            self._pool = ThreadPoolExecutor(self._threads, thread_name_prefix="flatland_gym")

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        chosen = dict(zip(indices.tolist(), episodes))
        self._make_places(chosen)
        self._each(lambda index: self._places[index].reset(chosen[index]), list(chosen))

    def is_blocked(self, index: int, episode: Episode) -> bool:
        return episode.is_near(self.added_walls(index), self._room)

    def added_walls(self, index: int) -> Segments:
        return self._places[index].added_walls()

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        numbers = self._by_place(indices)

        def step(place: int) -> None:
            own = numbers[place]
            self._places[place].step(own.tolist(), actions[self._rows_of(place)][own].tolist())

        self._each(step, list(numbers))

    def drive(self, command: Sequence[float]) -> None:
        self._places[0].step((0,), (command,))

    def retire(self, indices: IntArray, leaving: BoolArray) -> None:
        for place, numbers in self._by_place(indices).items():
            self._places[place].retire(numbers.tolist(), leaving[self._rows_of(place)])

    def save_states(self, indices: IntArray) -> List[bytes]:
        return [self._places[index].save_state() for index in indices.tolist()]

    def load_states(self, indices: IntArray, states: Sequence[bytes]) -> None:
        chosen = dict(zip(indices.tolist(), states))
        self._make_places(chosen)
        self._each(lambda index: self._places[index].load_state(chosen[index]), list(chosen))

    def simulation(self, index: int) -> Simulation:
        return self._places[index].simulation

    def motions(self, indices: IntArray) -> Motions:
        places = (indices // self._team).tolist()
        found = [self._places[place].motions() for place in places]
        poses, velocities = (np.stack(arrays) for arrays in zip(*found))
        return poses, velocities

    def close(self) -> None:
        for place in self._places.values():
            place.close()
        if self._pool is not None:
            self._pool.shutdown()

    def _rows_of(self, place: int) -> slice:
        """The rows of a place's robots."""
        return slice(place * self._team, (place + 1) * self._team)

    def _by_place(self, indices: IntArray) -> Dict[int, IntArray]:
        """The numbers of robots in their places, from their rows."""
        places = indices // self._team
        first = np.flatnonzero(np.diff(places, prepend=-1))
        numbers = np.split(indices % self._team, first[1:])
        return dict(zip(places[first].tolist(), numbers))

    def _make_places(self, indices: Iterable[int]) -> None:
        for index in set(indices) - self._places.keys():
            row = BatchObservation._make(array[self._rows_of(index)] for array in self._rows)
            self._places[index] = _Place(self._world, self._settings, row)

    def _each(self, do: Callable[[int], None], indices: List[int]) -> None:
        """Calls a function with each index, on all threads."""

        def do_all(part: List[int]) -> None:
            for index in part:
                do(index)

        if self._pool is None or len(indices) < 2:
            do_all(indices)
            return
        parts = [indices[start :: self._threads] for start in range(self._threads)]
        for _ in self._pool.map(do_all, parts):  # raises the exceptions of the parts
            pass


Fleet = Union[BatchFleet, SimulationFleet]


def make_fleet(
    world: NavigationWorld,
    settings: NavigationSettings,
    rows: BatchObservation,
    threads: int,
    maps: Optional[Maps],
) -> Fleet:
    """The fastest fleet for a world.

    Raises:
        PluginError: with maps, a plugin of the world runs in Python at each step.
    """
    try:
        return BatchFleet(world, settings, rows, threads, maps)
    except PluginError:
        if maps is not None:
            raise
        return SimulationFleet(world, settings, rows, threads)

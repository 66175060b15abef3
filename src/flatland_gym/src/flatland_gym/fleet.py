"""Simulations side by side: the backends of navigation environments.

A `Fleet` has n places, each with a simulation of the same world. It writes what the robots measure
into the arrays of a `BatchObservation`, which fleets of several worlds share.
"""

from abc import ABC, abstractmethod
from concurrent.futures import ThreadPoolExecutor
from typing import Callable, Dict, List, Optional, Sequence

import numpy as np

from flatland2d import BatchObservation, PluginError, Simulation, SimulationBatch
from flatland_gym.episodes import Episode
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.settings import NavigationSettings
from flatland_server import Body, FloatArray, IntArray, ModelPlugin

_ONLY = np.array([0])


class Fleet(ABC):
    """A world at n places.

    Args:
        world: that is simulated.
        settings: of the environment.
        rows: what the robots measure; overwritten in each step.
    """

    def __init__(
        self, world: NavigationWorld, settings: NavigationSettings, rows: BatchObservation
    ) -> None:
        self._world = world
        self._settings = settings
        self._rows = rows
        self._room = world.radius + settings.margin

    @abstractmethod
    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        """Begins an episode at each of these places."""

    @abstractmethod
    def is_blocked(self, index: int, episode: Episode) -> bool:
        """True if plugins have added walls at a start or a goal of a place's episode."""

    @abstractmethod
    def step(self, actions: FloatArray, indices: IntArray) -> None:
        """Makes a step of the environment with each of these robots.

        Args:
            actions: of all robots, shape (n, size of an action); finite.
            indices: of the robots' rows, in increasing order.
        """

    @abstractmethod
    def simulation(self, index: int) -> Simulation:
        """The simulation at a place, for pictures."""

    @abstractmethod
    def close(self) -> None:
        """Ends all simulations."""


class RobotSimulation(Fleet):
    """A single `Simulation` with one robot or several, each with a row.

    Works with every plugin, and with models that move.
    """

    _simulation: Optional[Simulation] = None  # made with the seed of the first episode

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        world, (episode,) = self._world, episodes
        if self._simulation is None:
            self._simulation = Simulation(
                world.config,
                seed=episode.seed,
                step_size=self._settings.step_size,
                params=self._settings.params,
            )
            self._numbers = {name: number for number, name in enumerate(world.robots)}
        else:
            self._simulation.reset(episode.seed)
        for name, pose in (*zip(world.robots, episode.starts), *episode.places.items()):
            self._simulation.move(name, pose)
        self._physics = self._simulation.world.physics
        robots = [self._simulation.models[name] for name in world.robots]
        self._bodies: List[Body] = [robot.model.base.physics_body for robot in robots]
        self._drives: List[ModelPlugin] = [robot.plugin(world.robot.drive) for robot in robots]
        self._lidars: List[ModelPlugin] = [robot.plugin(world.robot.lidar) for robot in robots]
        rows = self._rows
        self._views = list(zip(rows.ranges, rows.poses, rows.local_velocities))
        rows.collided[:] = False
        self._look(range(len(robots)))

    def is_blocked(self, index: int, episode: Episode) -> bool:
        config = self._world.config
        added = [
            layer.segments[len(config.walls_of(layer.config)) :]
            for layer in self.simulation(index).world.layers
        ]
        return episode.is_near(np.concatenate([np.empty((0, 4)), *added]), self._room)

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        self.drive(indices.tolist(), actions[indices].tolist())

    def drive(self, numbers: Sequence[int], commands: Sequence[Sequence[float]]) -> None:
        """Makes a step of the environment with some robots.

        Args:
            numbers: of the robots' rows.
            commands: of each of these robots; finite.
        """
        simulation, collided = self.simulation(0), self._rows.collided
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

    def simulation(self, index: int) -> Simulation:
        assert self._simulation is not None  # there is one from the first episode on
        return self._simulation

    def close(self) -> None:
        if self._simulation is not None:
            self._simulation.close()

    def _look(self, numbers: Sequence[int]) -> None:
        """Writes the measurements of some robots."""
        timekeeper = self.simulation(0).timekeeper
        for number in numbers:
            ranges, pose, velocity = self._views[number]
            ranges[:] = self._lidars[number].read(timekeeper)
            self._bodies[number].read_motion(pose, velocity)


class SimulationFleet(Fleet):
    """A `RobotSimulation` at each place, made when it is first needed.

    Args:
        world: that is simulated.
        settings: of the environment.
        rows: what the robots measure; one robot at each place.
        threads: how many places are stepped at a time.
    """

    def __init__(
        self,
        world: NavigationWorld,
        settings: NavigationSettings,
        rows: BatchObservation,
        threads: int = 1,
    ) -> None:
        super().__init__(world, settings, rows)
        self._places: Dict[int, RobotSimulation] = {}
        self._threads = min(threads, len(rows.poses))
        self._pool: Optional[ThreadPoolExecutor] = None
        if self._threads > 1:
            self._pool = ThreadPoolExecutor(self._threads, thread_name_prefix="flatland_gym")

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        chosen = dict(zip(indices.tolist(), episodes))
        for index in chosen.keys() - self._places.keys():
            row = BatchObservation._make(array[index : index + 1] for array in self._rows)
            self._places[index] = RobotSimulation(self._world, self._settings, row)
        self._each(lambda index: self._places[index].reset(_ONLY, [chosen[index]]), list(chosen))

    def is_blocked(self, index: int, episode: Episode) -> bool:
        return self._places[index].is_blocked(0, episode)

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        self._each(
            lambda index: self._places[index].step(actions[index : index + 1], _ONLY),
            indices.tolist(),
        )

    def simulation(self, index: int) -> Simulation:
        return self._places[index].simulation(0)

    def close(self) -> None:
        for place in self._places.values():
            place.close()
        if self._pool is not None:
            self._pool.shutdown()

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


class BatchFleet(Fleet):
    """A `SimulationBatch`: all places in one call of the core.

    It gives the same numbers as a `SimulationFleet`, bit for bit.

    Args:
        world: that is simulated.
        settings: of the environment.
        rows: what the robots measure; one robot at each place.
        threads: of the batch.

    Raises:
        PluginError: a plugin of the world runs in Python at each step.
    """

    def __init__(
        self,
        world: NavigationWorld,
        settings: NavigationSettings,
        rows: BatchObservation,
        threads: int = 1,
    ) -> None:
        super().__init__(world, settings, rows)
        count = len(rows.poses)
        self._moved = [disc.name for disc in (*world.scattered, *world.obstacles)]
        self._batch = SimulationBatch(
            world.config,
            count,
            robot=world.robot.name,
            lidar=world.robot.lidar,
            threads=min(threads, count),
            moved=self._moved,
            step_size=settings.step_size,
            params=settings.params,
        )
        self._places = np.zeros((count, len(self._moved), 3))

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        count = len(self._rows.poses)
        mask, seeds, poses = np.zeros(count, bool), np.zeros(count, np.int64), np.zeros((count, 3))
        mask[indices] = True
        seeds[indices] = [episode.seed for episode in episodes]
        poses[indices] = [episode.starts[0] for episode in episodes]
        places = self._places
        for index, episode in zip(indices.tolist(), episodes):
            places[index] = np.array([episode.places[name] for name in self._moved]).reshape(-1, 3)
        self._batch.reset(mask, seeds, poses, out=self._rows, model_poses=places)

    def is_blocked(self, index: int, episode: Episode) -> bool:
        return episode.is_near(self._batch.added_walls(index), self._room)

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        mask = None
        if len(indices) < len(actions):
            mask = np.zeros(len(actions), bool)
            mask[indices] = True
        self._batch.step(actions, self._settings.frame_skip, out=self._rows, mask=mask)

    def simulation(self, index: int) -> Simulation:
        """A simulation that shows the place: the same one for all places."""
        return self._batch.view(index)

    def close(self) -> None:
        self._batch.close()


def make_fleet(
    world: NavigationWorld, settings: NavigationSettings, rows: BatchObservation, threads: int
) -> Fleet:
    """The fastest fleet for a world."""
    try:
        return BatchFleet(world, settings, rows, threads)
    except PluginError:
        return SimulationFleet(world, settings, rows, threads)

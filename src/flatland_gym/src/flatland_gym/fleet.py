"""Simulations side by side: the backends of navigation environments.

A `Fleet` has n places; each has a robot in a world. Its arrays are overwritten by its next call;
learners always get copies.
"""

from abc import ABC, abstractmethod
from concurrent.futures import ThreadPoolExecutor
from typing import Callable, Dict, List, Optional, Sequence

from flatland2d import BatchObservation, Simulation
from flatland_gym.episodes import Episode
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.robot_rows import RobotRows
from flatland_gym.robot_simulation import RobotSimulation
from flatland_gym.settings import NavigationSettings
from flatland_server import FloatArray, IntArray


class Fleet(RobotRows, ABC):
    """The state of n robots, one in each of n simulations.

    Args:
        count: of places, n.
        beams: of the lidar.
        arrays: that the state is written to; None: new ones. Fleets may share them, if each place
            is used in one of the fleets at a time.
    """

    def __init__(self, count: int, beams: int, arrays: Optional[BatchObservation] = None) -> None:
        super().__init__(arrays or BatchObservation.empty(count, beams))

    @abstractmethod
    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        """Begins an episode at each of these places."""

    def is_blocked(self, index: int, episode: Episode) -> bool:
        """Whether plugins have added walls at the start or the goal of a place's episode."""
        return False

    @abstractmethod
    def step(self, actions: FloatArray, indices: IntArray) -> None:
        """Makes a step of the environment at each of these places.

        Args:
            actions: shape (n, size of an action); finite.
            indices: of the places, in increasing order.
        """

    @abstractmethod
    def simulation(self, index: int) -> Simulation:
        """The simulation at a place, for pictures."""

    @abstractmethod
    def close(self) -> None:
        """Ends all simulations."""


class SimulationFleet(Fleet):
    """A `Simulation` for each place and each world that was needed there.

    Works with every plugin, and with models that move.

    Args:
        worlds: that episodes choose from.
        settings: of the environment.
        count: of places.
        threads: how many of them are stepped at a time.
        arrays: see `Fleet`.
    """

    def __init__(
        self,
        worlds: Sequence[NavigationWorld],
        settings: NavigationSettings,
        count: int,
        threads: int = 1,
        arrays: Optional[BatchObservation] = None,
    ) -> None:
        super().__init__(count, worlds[0].robot.beams, arrays)
        self._worlds = worlds
        self._settings = settings
        self._simulations: List[Dict[int, RobotSimulation]] = [{} for _ in range(count)]
        self._current: Dict[int, RobotSimulation] = {}
        self._pool: Optional[ThreadPoolExecutor] = None
        self._threads = min(threads, count)
        if self._threads > 1:
            self._pool = ThreadPoolExecutor(self._threads, thread_name_prefix="flatland_gym")

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        chosen = dict(zip(indices.tolist(), episodes))

        def begin(index: int) -> None:
            simulation = self._current[index] = self._at(index, chosen[index].world)
            simulation.begin(chosen[index])
            simulation.look(self, index)

        self._each(begin, list(chosen))
        self.collided[indices] = False

    def is_blocked(self, index: int, episode: Episode) -> bool:
        return self._current[index].is_blocked(episode)

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        commands = actions.tolist()

        def advance(index: int) -> None:
            simulation = self._current[index]
            simulation.command(0, commands[index])
            self.collided[index] = simulation.step(self._settings.frame_skip)[0]
            simulation.look(self, index)

        self._each(advance, indices.tolist())

    def simulation(self, index: int) -> Simulation:
        return self._current[index].simulation

    def close(self) -> None:
        for simulations in self._simulations:
            for simulation in simulations.values():
                simulation.close()
        if self._pool is not None:
            self._pool.shutdown()

    def _at(self, index: int, world: int) -> RobotSimulation:
        """The simulation of a world at a place; made when it is first needed."""
        simulations = self._simulations[index]
        if world not in simulations:
            simulations[world] = RobotSimulation(self._worlds[world], self._settings)
        return simulations[world]

    def _each(self, do: Callable[[int], None], indices: List[int]) -> None:
        """Calls a function with each index, on all threads."""
        if self._pool is None or len(indices) < 2:
            for index in indices:
                do(index)
            return

        def do_all(part: List[int]) -> None:
            for index in part:
                do(index)

        parts = [indices[start :: self._threads] for start in range(self._threads)]
        for _ in self._pool.map(do_all, parts):  # raises the exceptions of the parts
            pass

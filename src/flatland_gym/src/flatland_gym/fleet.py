"""Simulations side by side: what a navigation environment drives and looks at.

A `Fleet` has n places; each has a robot in a world. Its arrays are overwritten by its next call;
what is handed to learners is always a copy.
"""

from concurrent.futures import ThreadPoolExecutor
from typing import Callable, Dict, List, Optional, Sequence

import numpy as np

from flatland_gym.episodes import Episode
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.settings import NavigationSettings
from flatland_server import BoolArray, Float32Array, FloatArray, IntArray, ModelPlugin, Simulation


class Fleet:
    """The state of n robots, as arrays.

    Attributes:
        ranges: [m], +inf for no return; float32, shape (n, beams).
        poses: x, y [m] and yaw [rad] in the world, shape (n, 3).
        velocities: in the robots' frames, shape (n, 3): forwards, to the left, turning.
        collided: whether a robot has touched something solid in its last step, shape (n,).
    """

    def __init__(self, count: int, beams: int) -> None:
        self.ranges: Float32Array = np.zeros((count, beams), np.float32)
        self.poses: FloatArray = np.zeros((count, 3))
        self.velocities: FloatArray = np.zeros((count, 3))
        self.collided: BoolArray = np.zeros(count, dtype=bool)

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        """Begins an episode at each of these places."""
        raise NotImplementedError

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        """Makes a step of the environment at each of these places.

        Args:
            actions: shape (n, size of an action); finite.
            indices: of the places, in increasing order.
        """
        raise NotImplementedError

    def simulation(self, index: int) -> Simulation:
        """The simulation at a place, to be looked at: for pictures."""
        raise NotImplementedError

    def close(self) -> None:
        """Ends all simulations."""
        raise NotImplementedError


class SimulationFleet(Fleet):
    """A `Simulation` for each place and each world that was needed there.

    Works with every plugin, and with models that move.

    Args:
        worlds: what episodes are in.
        settings: of the environment.
        count: of places.
        threads: how many of them are stepped at a time.
    """

    def __init__(
        self,
        worlds: Sequence[NavigationWorld],
        settings: NavigationSettings,
        count: int,
        threads: int = 1,
    ) -> None:
        super().__init__(count, worlds[0].robot.beams)
        self._worlds = worlds
        self._settings = settings
        self._berths: List[Dict[int, _Berth]] = [{} for _ in range(count)]
        self._current: List[_Berth] = []
        self._pool: Optional[ThreadPoolExecutor] = None
        self._threads = min(threads, count)
        if self._threads > 1:
            self._pool = ThreadPoolExecutor(self._threads, thread_name_prefix="flatland_gym")

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        chosen = dict(zip(indices.tolist(), episodes))
        if not self._current:
            self._current = [self._berth(i, chosen[i].world) for i in range(len(self._berths))]

        def begin(index: int) -> None:
            berth = self._current[index] = self._berth(index, chosen[index].world)
            berth.begin(chosen[index])
            self._look(index, berth)

        self._each(begin, list(chosen))
        self.collided[indices] = False

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        commands = actions.tolist()

        def advance(index: int) -> None:
            berth = self._current[index]
            self.collided[index] = berth.step(commands[index], self._settings.frame_skip)
            self._look(index, berth)

        self._each(advance, indices.tolist())

    def simulation(self, index: int) -> Simulation:
        return self._current[index].simulation

    def close(self) -> None:
        for berths in self._berths:
            for berth in berths.values():
                berth.simulation.close()
        if self._pool is not None:
            self._pool.shutdown()

    def _berth(self, index: int, world: int) -> "_Berth":
        """The simulation of a world at a place; made when it is first needed."""
        berths = self._berths[index]
        if world not in berths:
            berths[world] = _Berth(self._worlds[world], self._settings)
        return berths[world]

    def _look(self, index: int, berth: "_Berth") -> None:
        self.ranges[index] = berth.scan()
        self.poses[index] = berth.handle.pose
        self.velocities[index] = berth.handle.local_velocity

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
        for _ in self._pool.map(do_all, parts):  # raises what a part has raised
            pass


class _Berth:
    """A simulation with its robot."""

    def __init__(self, world: NavigationWorld, settings: NavigationSettings) -> None:
        self._robot = world.robot
        self.simulation = Simulation(
            world.config, step_size=settings.step_size, params=settings.params
        )
        self.handle = self.simulation.models[self._robot.name]
        self._drive: Optional[ModelPlugin] = None
        self._lidar: Optional[ModelPlugin] = None

    def begin(self, episode: Episode) -> None:
        """Makes the world anew, and puts everything to its place."""
        simulation = self.simulation
        simulation.reset(episode.seed)
        simulation.move(self._robot.name, episode.start)
        for name, pose in episode.places.items():
            simulation.move(name, pose)
        self._drive = self.handle.plugin(self._robot.drive)
        self._lidar = self.handle.plugin(self._robot.lidar)

    def step(self, command: Sequence[float], count: int) -> bool:
        """Drives; returns whether the robot has touched something solid meanwhile."""
        assert self._drive is not None
        self._drive.command(*command)
        collided = False
        for _ in range(count):
            self.simulation.step()
            collided = collided or self._touches()
        return collided

    def scan(self) -> Float32Array:
        """The ranges of now."""
        assert self._lidar is not None
        ranges: Float32Array = self._lidar.read(self.simulation.timekeeper)
        return ranges

    def _touches(self) -> bool:
        name = self._robot.name
        return any(
            touch.points and touch.of(name) and touch.model_a != touch.model_b
            for touch in self.simulation.contacts
        )

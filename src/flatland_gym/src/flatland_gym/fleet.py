"""Worlds side by side: the backends of navigation environments.

A fleet has n places, each with a simulation of the same world. It writes what the robots measure
into the arrays of a `BatchObservation`, which fleets of several worlds share. It is a `BatchFleet`,
or a `SimulationFleet` with the same methods.
"""

from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from flatland2d import BatchObservation, Simulation, SimulationBatch
from flatland_gym.episodes import Episode
from flatland_gym.maps import Maps
from flatland_gym.navigation_world import NavigationWorld, parking_place
from flatland_gym.settings import NavigationSettings
from flatland_server import BoolArray, FloatArray, IntArray, Segments

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

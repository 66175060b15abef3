"""A fleet in one call of the core: for worlds in which Python has nothing to do at each step."""

from typing import Optional, Sequence

import numpy as np

from flatland2d import BatchObservation, Simulation, SimulationBatch
from flatland_gym.episodes import Episode
from flatland_gym.fleet import Fleet
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.settings import NavigationSettings
from flatland_server import BoolArray, FloatArray, IntArray


class BatchFleet(Fleet):
    """A `SimulationBatch`. It gives the same numbers as a `SimulationFleet`, bit for bit.

    Args:
        world: of all episodes.
        settings: of the environment.
        count: of places.
        threads: of the batch.
        arrays: see `Fleet`.

    Raises:
        PluginError: a plugin of the world runs in Python at each step.
    """

    def __init__(
        self,
        world: NavigationWorld,
        settings: NavigationSettings,
        count: int,
        threads: int = 1,
        arrays: Optional[BatchObservation] = None,
    ) -> None:
        super().__init__(count, world.robot.beams, arrays)
        self._settings = settings
        self._room = world.radius + settings.margin
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
        count = len(self.poses)
        seeds, poses = np.zeros(count, np.int64), np.zeros((count, 3))
        seeds[indices] = [episode.seed for episode in episodes]
        poses[indices] = [episode.starts[0] for episode in episodes]
        places = self._places
        for index, episode in zip(indices.tolist(), episodes):
            places[index] = np.array([episode.places[name] for name in self._moved]).reshape(-1, 3)
        self._batch.reset(self._mask(indices), seeds, poses, out=self.arrays, model_poses=places)

    def is_blocked(self, index: int, episode: Episode) -> bool:
        return episode.is_near(self._batch.added_walls(index), self._room)

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        mask = None if len(indices) == len(self.poses) else self._mask(indices)
        self._batch.step(actions, self._settings.frame_skip, out=self.arrays, mask=mask)

    def simulation(self, index: int) -> Simulation:
        """A simulation that shows the place: the same one for all places."""
        return self._batch.view(index)

    def close(self) -> None:
        self._batch.close()

    def _mask(self, indices: IntArray) -> BoolArray:
        mask = np.zeros(len(self.poses), bool)
        mask[indices] = True
        return mask

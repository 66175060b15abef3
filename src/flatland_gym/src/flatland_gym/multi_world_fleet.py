"""A fleet for episodes in several worlds, or with several sizes of the robot."""

from typing import Dict, Optional, Sequence

import numpy as np

from flatland2d import PluginError, Simulation
from flatland_gym.batch_fleet import BatchFleet
from flatland_gym.episodes import Episode
from flatland_gym.fleet import Fleet, SimulationFleet
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.settings import NavigationSettings
from flatland_server import FloatArray, IntArray


class MultiWorldFleet(Fleet):
    """A `BatchFleet` for each world, made when an episode first is in this world.

    Each batch has an environment for every place, and steps the places that are in its world.
    All write to the same arrays. Worlds in which a plugin runs in Python at each step share a
    `SimulationFleet`. The numbers are, bit for bit, those of a `SimulationFleet` of all worlds.

    Args:
        worlds: that episodes choose from.
        settings: of the environment.
        count: of places.
        threads: of each batch.
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
        self._threads = threads
        self._fleets: Dict[int, Fleet] = {}
        self._in_python: Optional[SimulationFleet] = None
        self._world_of = np.full(count, -1)
        """The index of the world at each place."""

    def reset(self, indices: IntArray, episodes: Sequence[Episode]) -> None:
        drawn = np.array([episode.world for episode in episodes])
        for world in np.unique(drawn).tolist():
            chosen = np.flatnonzero(drawn == world)
            self._fleet(world).reset(indices[chosen], [episodes[k] for k in chosen.tolist()])
            self._world_of[indices[chosen]] = world

    def is_blocked(self, index: int, episode: Episode) -> bool:
        return self._fleet(episode.world).is_blocked(index, episode)

    def step(self, actions: FloatArray, indices: IntArray) -> None:
        present = self._world_of[indices]
        for world, fleet in self._fleets.items():
            chosen = indices[present == world]
            if len(chosen):
                fleet.step(actions, chosen)

    def simulation(self, index: int) -> Simulation:
        return self._fleets[int(self._world_of[index])].simulation(index)

    def close(self) -> None:
        for fleet in self._fleets.values():
            fleet.close()

    def _fleet(self, world: int) -> Fleet:
        """The fleet of a world; made when it is first needed."""
        if world not in self._fleets:
            self._fleets[world] = self._new_fleet(world)
        return self._fleets[world]

    def _new_fleet(self, world: int) -> Fleet:
        shared = len(self.poses), self._threads, self.arrays
        try:
            return BatchFleet(self._worlds[world], self._settings, *shared)
        except PluginError:
            if self._in_python is None:
                self._in_python = SimulationFleet(self._worlds, self._settings, *shared)
            return self._in_python


def make_fleet(
    worlds: Sequence[NavigationWorld], settings: NavigationSettings, count: int, threads: int
) -> Fleet:
    """The fastest fleet for these worlds."""
    if len(worlds) > 1:
        return MultiWorldFleet(worlds, settings, count, threads)
    try:
        return BatchFleet(worlds[0], settings, count, threads)
    except PluginError:
        return SimulationFleet(worlds, settings, count, threads)

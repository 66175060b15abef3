"""The worlds of a batch with plugins that act at random when loaded, such as RandomWall."""

from typing import Callable, Dict, List, Optional, Sequence

import numpy as np

from flatland2d.batch.robot import PluginRole, require_unchanged_footprints
from flatland_server import _core
from flatland_server.arrays import BoolArray, IntArray, Segments
from flatland_server.simulation import World


class BatchWorlds:
    """Loads a world for each environment, with its seed, where worlds differ by their seeds.

    Args:
        roles: of the plugins of the world, which is shared unless one varies by the seed.
        count: number of environments, n.
        open: returns the world of a seed.
        is_random: whether the world's files depend on the seed.
    """

    def __init__(
        self,
        roles: Sequence[PluginRole],
        count: int,
        open: Callable[[int], World],
        is_random: bool,
    ) -> None:
        self._differ = is_random or any(each.role.varies_by_seed for each in roles)
        self._open = open
        self._last: Optional[World] = None
        self._loaded = np.full(count, -1, np.int64)
        """The seed with which the world of each environment was loaded."""
        self._walls: Dict[int, List[Segments]] = {}

    def __bool__(self) -> bool:
        """True if environments have worlds of their own."""
        return self._differ

    def load(self, core: _core.WorldBatch, chosen: BoolArray, seeds: IntArray) -> BoolArray:
        """Reloads the worlds of chosen environments after a change of their seed.

        Returns:
            The mask of environments with a new world, which has made no step.
        """
        is_other: BoolArray = chosen & (self._loaded != seeds)
        for k in np.flatnonzero(is_other).tolist():
            world = self._load(int(seeds[k]))
            core.replace(k, world.physics)
            self._walls[k] = [layer.segments for layer in world.layers]
            self._loaded[k] = seeds[k]
        return is_other

    def walls(self, environment: int) -> Optional[List[Segments]]:
        """The walls of each layer of an environment with a world of its own."""
        return self._walls.get(environment)

    def close(self) -> None:
        """Closes the world that was loaded last."""
        if self._last is not None:
            self._last.close()

    def _load(self, seed: int) -> World:
        if self._last is None:
            self._last = self._open(seed)
        else:
            self._last.reset(seed)
        require_unchanged_footprints(self._last)
        return self._last

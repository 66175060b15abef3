"""Maps of episodes: walls that a function makes, in place of those of the world's first layer."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from flatland2d import UsageError, Walls
from flatland_gym.map_space import MapSpace
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.settings import NavigationSettings
from flatland_server._core import LinesOfSight

_KEPT = 256
"""Maps that are kept besides those of the environments, if there are so many."""


@dataclass(frozen=True)
class Map:
    """A map of some episodes.

    Attributes:
        walls: for the batch.
        world: with these walls.
        lines: which lines of sight the walls block.
    """

    walls: Walls
    world: NavigationWorld
    lines: LinesOfSight


class Maps:
    """The maps that a function makes by their numbers, and the last ones of them.

    Args:
        settings: of the environments, with `maps`.
        world: world in which each map replaces the walls of the first layer.
        count: number of environments.
    """

    def __init__(self, settings: NavigationSettings, world: NavigationWorld, count: int) -> None:
        self._make: Any = settings.maps
        self._world = world
        self._get = lru_cache(count + _KEPT)(self._made)

    def __getitem__(self, number: int) -> Map:
        return self._get(number)

    def _made(self, number: int) -> Map:
        """Makes a map.

        Raises:
            UsageError: the function has returned no walls.
        """
        made: Any = self._make(np.random.default_rng(number))
        try:
            segments = np.ascontiguousarray(made, np.float64)
            walls = Walls(segments)
        except (TypeError, ValueError) as error:
            raise UsageError(f"maps: the walls of map {number}: {error}") from None
        if not len(segments):
            raise UsageError(f"maps: expected walls of map {number}, found none")
        space = MapSpace(segments)
        world = replace(self._world, walls=segments, space=space)
        return Map(walls, world, LinesOfSight(segments))

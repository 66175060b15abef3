"""The free space for the initial poses of a batch's robots."""

from typing import Any, Dict, Sequence

import numpy as np

from flatland2d.free_space import DistanceGrid, FreeSpace, discs_of
from flatland2d.robot import Robot
from flatland_server.arguments import shown
from flatland_server.arrays import FloatArray
from flatland_server.config import LARGEST
from flatland_server.exceptions import UsageError
from flatland_server.simulation import World


class FreeSpaces:
    """The free space of robots for each clearance, computed when it is first needed.

    Args:
        world: the initial world of all environments.
        robots: their models; the other models are obstacles.
    """

    def __init__(self, world: World, robots: Sequence[Robot]) -> None:
        self._world = world
        self._robots = [robot.model for robot in robots]
        self._spaces: Dict[float, FreeSpace] = {}

    def of(self, clearance: Any) -> FreeSpace:
        """The free space with a distance [m] from all walls and the circles around other models.

        Raises:
            UsageError: the clearance is not usable, or leaves no place.
        """
        is_number = isinstance(clearance, (int, float, np.number))
        if not (is_number and 0.0 < clearance <= LARGEST):
            raise UsageError(f"expected a clearance above zero, found {shown(clearance)}")
        if clearance not in self._spaces:
            self._spaces[clearance] = self._compute(clearance)
        return self._spaces[clearance]

    def _compute(self, clearance: float) -> FreeSpace:
        others = [each for each in self._world.models.values() if each not in self._robots]
        grid = DistanceGrid(
            self._walls(),
            self._robots[0].pose[:2],
            clearance,
            discs=discs_of((each.pose, each.radius) for each in others),
            resolution=min(max(clearance / 6.0, 0.02), 0.1),
        )
        space = grid.free_space(clearance)
        if space.area == 0.0:
            raise UsageError(f"no place has a clearance of {clearance:g} m")
        return space

    def _walls(self) -> FloatArray:
        """The walls that the robots collide with: shape (n, 4)."""
        bits = 0
        for robot in self._robots:
            for body in robot.physics_bodies:
                for fixture in body.fixtures:
                    bits |= fixture.layers
        config = self._world.config
        walls = [config.walls_of(layer) for layer in config.layers if layer.bits & bits]
        return np.concatenate([np.empty((0, 4)), *walls])

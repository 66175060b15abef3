"""The free space of a robot on one map of many."""

import math
from typing import Dict

import numpy as np

from flatland2d import DistanceGrid, FreeSpace
from flatland_server import FloatArray, Segments, from_segments


class MapSpace:
    """The free space of a robot on a map: like a `DistanceGrid`, in a hundredth of the memory.

    Args:
        walls: shape (n, 4) [m].
    """

    def __init__(self, walls: Segments) -> None:
        self._walls = walls
        self._spaces: Dict[float, FreeSpace] = {}
        ends = walls.reshape(-1, 2)
        self.diagonal = math.hypot(*(ends.max(axis=0) - ends.min(axis=0)).tolist())

    def distance(self, x: float, y: float) -> float:
        """A place's distance from walls [m]."""
        away: FloatArray = from_segments(np.array([[x, y]]), self._walls)
        return float(np.hypot(away[..., 0], away[..., 1]).min())

    def free_space(self, clearance: float) -> FreeSpace:
        """As `DistanceGrid.free_space`: the largest part that is connected."""
        if clearance not in self._spaces:
            grid = DistanceGrid(self._walls, None, clearance)
            self._spaces[clearance] = grid.free_space(clearance)
        return self._spaces[clearance]

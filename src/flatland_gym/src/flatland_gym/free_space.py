"""Where a robot can stand: a grid of distances from walls, and what is connected on it."""

import math
from typing import Tuple

import numpy as np

from flatland_server import BoolArray, FloatArray, IntArray, Segments

_CELL = 0.05
_MOST_CELLS = 4_000_000
_OPEN = 10.0
"""How far the space reaches around the robot in a world without walls [m]."""


class FreeSpace:
    """The places within the walls of a world that are connected with a given one.

    Walls are drawn on a grid, and each cell has a lower bound of the distance of all of its points
    from the walls; so a place that is found here is never nearer to a wall than was asked for.

    Args:
        walls: shape (n, 4) [m].
        inside: a place between them, such as that of the robot in the world file: x, y [m].
        farthest: distances from walls are told up to here [m].
    """

    def __init__(self, walls: Segments, inside: Tuple[float, float], farthest: float) -> None:
        points = walls.reshape(-1, 2)
        if len(points) == 0:
            points = np.array(inside) + np.array([[-_OPEN, -_OPEN], [_OPEN, _OPEN]])
        self._low = np.minimum(points.min(axis=0), inside) - _CELL
        extent = np.maximum(points.max(axis=0), inside) + _CELL - self._low
        self._cell = max(_CELL, float(np.sqrt(extent.prod() / _MOST_CELLS)))
        rows, columns = (int(np.ceil(extent[i] / self._cell)) + 1 for i in (1, 0))
        self._inside = inside
        self._is_wall = np.zeros((rows, columns), dtype=bool)
        self._draw(walls)
        self._clearance = self._distances(farthest)

    def _draw(self, walls: Segments) -> None:
        """Marks the cells that walls cross; no gap is wider than half a cell."""
        for x1, y1, x2, y2 in walls:
            count = int(np.hypot(x2 - x1, y2 - y1) / (self._cell / 2)) + 2
            line = np.linspace((x1, y1), (x2, y2), count)
            columns, rows = ((line - self._low) / self._cell).astype(np.intp).T
            self._is_wall[rows, columns] = True

    def _distances(self, farthest: float) -> FloatArray:
        """Lower bounds of the distances from walls [m], up to a limit.

        The exact distance of cells, first along columns and then along rows, less what two points
        of the cells can be nearer than the cells' middles.
        """
        reach = int(np.ceil(farthest / self._cell)) + 2
        along = np.where(self._is_wall, 0, reach)
        for _ in range(reach):
            along[1:] = np.minimum(along[1:], along[:-1] + 1)
            along[:-1] = np.minimum(along[:-1], along[1:] + 1)
        square = along * along
        nearest = square.copy()
        for offset in range(1, reach):
            shifted = offset * offset
            np.minimum(nearest[:, offset:], square[:, :-offset] + shifted, nearest[:, offset:])
            np.minimum(nearest[:, :-offset], square[:, offset:] + shifted, nearest[:, :-offset])
        distances: FloatArray = (np.sqrt(nearest) - np.sqrt(2.0) - 0.5) * self._cell
        return np.maximum(distances, 0.0)

    @property
    def diagonal(self) -> float:
        """No two places are farther apart than this [m]."""
        return math.hypot(*self._is_wall.shape) * self._cell

    def clearance(self, x: float, y: float) -> float:
        """A lower bound of a place's distance from the walls [m]; 0 outside of the grid."""
        column, row = ((np.array((x, y)) - self._low) // self._cell).astype(int)
        rows, columns = self._is_wall.shape
        is_on_grid = 0 <= row < rows and 0 <= column < columns
        return float(self._clearance[row, column]) if is_on_grid else 0.0

    def cells(self, radius: float) -> IntArray:
        """The cells where a disc can stand that can get there from the place inside; flat indices.

        Args:
            radius: of the disc [m].
        """
        return np.flatnonzero(self._reachable(self._clearance > radius))

    def draw_point(self, cells: IntArray, rng: np.random.Generator) -> Tuple[float, float]:
        """A random point in one of the cells: x, y [m]."""
        cell = cells[rng.integers(len(cells))]
        row, column = divmod(int(cell), self._is_wall.shape[1])
        x, y = self._low + (np.array((column, row)) + rng.random(2)) * self._cell
        return float(x), float(y)

    def contains(self, cells: IntArray, x: float, y: float) -> bool:
        """Whether a point lies in one of the cells, which are sorted."""
        column = math.floor((x - self._low[0]) / self._cell)
        row = math.floor((y - self._low[1]) / self._cell)
        rows, columns = self._is_wall.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return False
        index = row * columns + column
        position = int(np.searchsorted(cells, index))
        return position < len(cells) and int(cells[position]) == index

    def _reachable(self, free: BoolArray) -> BoolArray:
        """The free cells that are connected with the free cell nearest to the place inside.

        Fills whole runs of cells at a time, along rows and columns in turn.
        """
        reached = np.zeros_like(free)
        rows, columns = np.nonzero(free)
        if len(rows) == 0:
            return reached
        middle = (np.array(self._inside) - self._low) / self._cell - 0.5
        nearest = np.argmin((columns - middle[0]) ** 2 + (rows - middle[1]) ** 2)
        reached[rows[nearest], columns[nearest]] = True
        runs = (_runs(free), _runs(free.T))
        count = 0
        while count != np.count_nonzero(reached):
            count = int(np.count_nonzero(reached))
            reached = _filled(reached, free, runs[0])
            reached = _filled(reached.T, free.T, runs[1]).T
        return reached


def _runs(free: BoolArray) -> IntArray:
    """A number for each run of equal cells along the rows."""
    changes = np.ones(free.shape, dtype=bool)
    changes[:, 1:] = free[:, 1:] != free[:, :-1]
    numbers: IntArray = np.cumsum(changes.ravel()).reshape(free.shape) - 1
    return numbers


def _filled(reached: BoolArray, free: BoolArray, runs: IntArray) -> BoolArray:
    """Extends what is reached to whole runs of free cells."""
    is_reached = np.zeros(int(runs[-1, -1]) + 1, dtype=bool)
    is_reached[runs[reached]] = True
    filled: BoolArray = is_reached[runs] & free
    return filled

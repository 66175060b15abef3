"""Where a robot may be: the floor that it can reach without touching a wall."""

import math
from typing import Iterable, Tuple

import numpy as np

from flatland_server.arrays import BoolArray, FloatArray, Segments
from flatland_server.exceptions import UsageError
from flatland_server.geometry import Pose
from flatland_server.library.arguments import whole_number

_MAX_SQUARES = 4_000_000


class FreeSpace:
    """The places at a distance from all obstacles that are connected with a start.

    The floor is divided into squares. A square is free if each of its points is as far from all
    obstacles as the clearance, and reachable if free squares lead to it from the start's, side by
    side, within the rectangle around all walls. So passages are lost that are wider than twice the
    clearance by less than two squares.

    Args:
        walls: shape (n, 4), x1, y1, x2, y2 [m].
        discs: other obstacles: shape (m, 3), x, y and radius [m].
        start: a point of the floor; if its square is not free, the nearest free one counts.
        clearance: distance from all obstacles [m], above zero.

    Attributes:
        clearance: that distance [m].
        resolution: side of a square [m].

    Raises:
        UsageError: the clearance is not usable, or there is no free square or no wall.
    """

    def __init__(
        self, walls: Segments, discs: FloatArray, start: Tuple[float, float], clearance: float
    ) -> None:
        if not (math.isfinite(clearance) and clearance > 0.0):
            raise UsageError(f"expected a clearance above zero, found {clearance!r}")
        self.clearance = float(clearance)
        if len(walls) == 0:
            raise UsageError("a world without walls has no end, so poses are chosen by its user")
        ends = walls.reshape(-1, 2)
        self._origin = ends.min(axis=0)
        size = ends.max(axis=0) - self._origin
        least = math.sqrt(size[0] * size[1] / _MAX_SQUARES)
        self.resolution = max(min(max(clearance / 6.0, 0.02), 0.1), least)
        shape = np.ceil(size[::-1] / self.resolution).astype(int) + 1
        free = np.ones(tuple(shape), dtype=bool)
        reach = clearance + self.resolution * math.sqrt(0.5)
        for x1, y1, x2, y2 in walls:
            self._block(free, np.array([x1, y1]), np.array([x2, y2]), reach)
        for x, y, radius in discs:
            self._block(free, np.array([x, y]), np.array([x, y]), reach + radius)
        self._reachable = connected(free, self._nearest(free, np.array(start)))
        self._rows, self._columns = np.nonzero(self._reachable)

    @property
    def area(self) -> float:
        """Of all reachable squares [m^2]."""
        return len(self._rows) * self.resolution**2

    def contains(self, points: FloatArray) -> BoolArray:
        """Whether points, shape (n, 2) or more columns, are in reachable squares: shape (n,)."""
        columns, rows = np.floor((points[:, :2] - self._origin) / self.resolution).T.astype(int)
        height, width = self._reachable.shape
        is_inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        found = self._reachable[rows.clip(0, height - 1), columns.clip(0, width - 1)]
        return np.asarray(is_inside & found)

    def poses(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Random poses, uniformly distributed over the reachable squares and all headings.

        Args:
            count: of the poses, 0 or more.
            rng: the random numbers.

        Returns:
            Shape (count, 3): x, y [m] and yaw in [-pi, pi) [rad].
        """
        whole_number(count, "a number of poses", 0)
        chosen = rng.integers(len(self._rows), size=count)
        squares = np.column_stack([self._columns[chosen], self._rows[chosen]])
        points = self._origin + (squares + rng.random((count, 2))) * self.resolution
        return np.column_stack([points, rng.uniform(-math.pi, math.pi, count)])

    def _block(self, free: BoolArray, a: FloatArray, b: FloatArray, reach: float) -> None:
        """Marks squares with their middles within `reach` of the line from a to b as not free."""
        low = np.floor((np.minimum(a, b) - reach - self._origin) / self.resolution).astype(int)
        high = np.ceil((np.maximum(a, b) + reach - self._origin) / self.resolution).astype(int)
        low = low.clip(0)
        xs = self._origin[0] + (np.arange(low[0], high[0]) + 0.5) * self.resolution - a[0]
        ys = self._origin[1] + (np.arange(low[1], high[1]) + 0.5)[:, None] * self.resolution - a[1]
        way = b - a
        square = float(way @ way)
        part = ((xs * way[0] + ys * way[1]) / square).clip(0.0, 1.0) if square > 0.0 else 0.0
        near = (xs - part * way[0]) ** 2 + (ys - part * way[1]) ** 2 <= reach * reach
        window = free[low[1] : high[1], low[0] : high[0]]
        window &= ~near[: window.shape[0], : window.shape[1]]

    def _nearest(self, free: BoolArray, point: FloatArray) -> Tuple[int, int]:
        """The row and column of the free square that is nearest to a point."""
        rows, columns = np.nonzero(free)
        if len(rows) == 0:
            raise UsageError(f"no place has a clearance of {self.clearance:g} m")
        squares = self._origin + (np.column_stack([columns, rows]) + 0.5) * self.resolution
        nearest = int(((squares - point) ** 2).sum(axis=1).argmin())
        return int(rows[nearest]), int(columns[nearest])


def discs_of(models: Iterable[Tuple[Pose, float]]) -> FloatArray:
    """Obstacles out of the poses and radii of models: shape (m, 3)."""
    return np.array([[pose.x, pose.y, radius] for pose, radius in models]).reshape(-1, 3)


def connected(free: BoolArray, start: Tuple[int, int]) -> BoolArray:
    """The squares that free ones connect, side by side, with a start."""
    reached = np.zeros_like(free)
    reached[start] = free[start]
    before = 0
    while np.count_nonzero(reached) > before:
        before = np.count_nonzero(reached)
        reached = _spread(reached, free)
        reached = _spread(reached.T, free.T).T
    return reached


def _spread(reached: BoolArray, free: BoolArray) -> BoolArray:
    """Extends the reached squares along the rows, up to those that are not free."""
    breaks = ~free
    breaks[:, 0] = True
    run = np.cumsum(breaks.ravel())  # the free squares of a run share a number
    is_reached = np.bincount(run, weights=reached.ravel()) > 0
    return np.asarray(is_reached[run].reshape(free.shape) & free)

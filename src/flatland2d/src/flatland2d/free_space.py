"""Free space: the floor that a robot can reach without touching a wall."""

import math
from functools import cached_property, lru_cache
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from flatland_server import _core
from flatland_server.arguments import shown, whole_number
from flatland_server.arrays import BoolArray, FloatArray, Segments
from flatland_server.exceptions import UsageError
from flatland_server.geometry import Point, Pose

_MAX_SQUARES = 4_000_000
Circle = Tuple[float, float, float]
"""x, y and radius [m] of a disc."""
Circles = Sequence[Circle]
_HALF_DIAGONAL = math.sqrt(0.5)  # of a square, in units of its side


class FreeSpace:
    """The places with a clearance from all obstacles that can be reached from a start.

    The floor is divided into squares. A square is free if the distance of each of its points from
    all obstacles is at least the clearance, and reachable if adjacent free squares, within the
    bounding rectangle of all walls, lead to it from the start. So a passage may count as closed
    unless it is wider than twice the clearance by two squares.

    Args:
        reachable: the squares, shape (rows, columns): a row has the same y.
        origin: x, y [m] of the corner of the first square.
        resolution: side of a square [m].
        clearance: distance from all obstacles [m].

    Attributes:
        clearance: that distance [m].
        resolution: side of a square [m].
        area: of all reachable squares [m^2].
    """

    def __init__(
        self, reachable: BoolArray, origin: FloatArray, resolution: float, clearance: float
    ) -> None:
        self.clearance = clearance
        self.resolution = resolution
        self._packed, self._columns = np.packbits(reachable, axis=1), reachable.shape[1]
        self._origin = origin
        self._squares = _core.FloorSquares(reachable, origin.tolist(), resolution)
        self.area = len(self._squares) * resolution**2

    def __reduce__(self) -> Tuple[Any, ...]:
        return FreeSpace, (self._reachable, self._origin, self.resolution, self.clearance)

    def contains(self, points: FloatArray) -> BoolArray:
        """True where a point is in a reachable square: shape (n,).

        Args:
            points: shape (n, 2), or with more columns: x, y [m].

        Raises:
            UsageError: they have another shape.
        """
        if np.ndim(points) != 2 or np.shape(points)[1] < 2:
            raise UsageError(f"expected points of shape (n, 2), found {np.shape(points)}")
        columns, rows = np.floor((points[:, :2] - self._origin) / self.resolution).T.astype(int)
        reachable = self._reachable
        height, width = reachable.shape
        is_inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        found = reachable[rows.clip(0, height - 1), columns.clip(0, width - 1)]
        return np.asarray(is_inside & found)

    def contains_point(self, x: float, y: float) -> bool:
        """True if a point is in a reachable square; quicker than `contains` for one.

        Args:
            x: the point's x coordinate [m].
            y: the point's y coordinate [m].
        """
        return (x, y) in self._squares

    def point(self, rng: np.random.Generator) -> Tuple[float, float]:
        """A random point in a reachable square, of which there must be one: x, y [m].

        Args:
            rng: generator of NumPy to draw from.
        """
        return self._squares.draw(rng)

    def clear_poses(
        self,
        rng: np.random.Generator,
        discs: Circles,
        radius: float,
        distance: float,
        count: int,
        tries: int,
    ) -> List[Optional[Pose]]:
        """Random poses of like discs, clear of others and of each other; None where none was found.

        Args:
            rng: generator of NumPy to draw from.
            discs: the others: x, y and radius [m].
            radius: the discs' radius [m].
            distance: of their middles from the edges of others [m].
            count: number of poses.
            tries: the largest number of points to draw for each.
        """
        found = self._squares.draw_clear(rng, discs, radius, distance, count, tries)
        return [None if pose is None else Pose(*pose) for pose in found]

    def ends(
        self,
        rng: np.random.Generator,
        given: Tuple[Optional[Point], Optional[Point]],
        distances: Tuple[float, float],
        radius: float,
        discs: Tuple[Circles, Circles],
        tries: int,
    ) -> Optional[Tuple[Pose, Point]]:
        """A random start and a goal of a disc, where it overlaps no others; None if none was found.

        Args:
            rng: generator of NumPy to draw from.
            given: start and goal; those that are not None are taken as they are.
            distances: the least and the largest distance of the two [m].
            radius: the disc's radius [m].
            discs: the others at the start, and those at the goal: x, y and radius [m].
            tries: the largest number of pairs to draw.
        """
        found = self._squares.draw_ends(rng, *given, distances, radius, *discs, tries)
        return None if found is None else (Pose(*found[0]), found[1])

    def poses(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Random poses, uniformly distributed over the reachable squares and all headings.

        Args:
            count: of the poses, 0 or more.
            rng: generator of NumPy to draw from.

        Returns:
            Shape (count, 3): x, y [m] and yaw in [-pi, pi) [rad].

        Raises:
            UsageError: an argument is wrong, or there is no reachable square.
        """
        whole_number(count, "a number of poses", 0)
        if not isinstance(rng, np.random.Generator):
            raise UsageError(
                f"expected rng as a numpy.random.Generator (numpy.random.default_rng(seed)), found "
                f"{shown(rng)}"
            )
        if count and not len(self._squares):
            raise UsageError("no place is free and can be reached")
        rows, columns = self._places
        chosen = rng.integers(len(rows), size=count)
        squares = np.column_stack([columns[chosen], rows[chosen]])
        points = self._origin + (squares + rng.random((count, 2))) * self.resolution
        return np.column_stack([points, rng.uniform(-math.pi, math.pi, count)])

    @property
    def _reachable(self) -> BoolArray:
        """The squares, a bit of which is kept each: a program may have hundreds of maps."""
        return np.unpackbits(self._packed, axis=1, count=self._columns).view(bool)

    @cached_property
    def _places(self) -> Tuple[Any, ...]:
        """The rows and the columns of the reachable squares."""
        return np.nonzero(self._reachable)


class DistanceGrid:
    """Distances to obstacles on a grid of squares, and the `FreeSpace` of a robot.

    Args:
        walls: shape (n, 4), x1, y1, x2, y2 [m].
        start: a point of the floor, from which free space is reached: x, y [m]; None: free space is
            the largest part that is connected.
        farthest: the largest distance in the grid [m].
        discs: other obstacles: shape (m, 3), x, y and radius [m].
        resolution: side of a square [m]; it is increased if there would be over 4 million squares.
        open_reach: how far the grid reaches from the start in a world without walls [m].

    Attributes:
        farthest: that distance [m].
        resolution: side of a square [m].

    Raises:
        UsageError: there is no wall, and no `open_reach`.
    """

    def __init__(
        self,
        walls: Segments,
        start: Optional[Tuple[float, float]],
        farthest: float,
        *,
        discs: FloatArray = np.empty((0, 3)),  # noqa: B008 (only read)
        resolution: float = 0.05,
        open_reach: float = 0.0,
    ) -> None:
        if len(walls) == 0 and open_reach <= 0.0:
            raise UsageError("the world has no walls that bound its free space: pass poses")
        ends = walls.reshape(-1, 2)
        if len(walls) == 0:
            ends = np.array(start or (0.0, 0.0)) + np.array([[-open_reach] * 2, [open_reach] * 2])
        self.farthest = farthest
        self._start = None if start is None else np.array(start, dtype=np.float64)
        self._origin = ends.min(axis=0)
        size = ends.max(axis=0) - self._origin
        self.resolution = max(resolution, math.sqrt(size[0] * size[1] / _MAX_SQUARES))
        shape = np.ceil(size[::-1] / self.resolution).astype(int) + 1
        self._reach = farthest + _HALF_DIAGONAL * self.resolution
        squared = np.full(tuple(shape), self._reach**2)
        segments = np.ascontiguousarray(walls, np.float64)
        corner = (self._origin[0], self._origin[1])
        _core.lower_to_walls(squared, segments, self._reach, corner, self.resolution)
        self._distances = np.sqrt(squared)  # of the middles of the squares
        for x, y, radius in discs.tolist():
            window, distances = self._around((x, y), self._reach + radius)
            np.minimum(window, distances - radius, out=window)
        self._spaces: Dict[float, FreeSpace] = {}

    @staticmethod
    def shared(
        walls: Segments,
        start: Tuple[float, float],
        farthest: float,
        *,
        discs: FloatArray = np.empty((0, 3)),  # noqa: B008 (only read)
        open_reach: float = 0.0,
    ) -> "DistanceGrid":
        """A new grid, or one that was made of equal arguments before.

        Args:
            walls: as for the class.
            start: as for the class.
            farthest: as for the class.
            discs: as for the class.
            open_reach: as for the class.
        """
        arrays = (np.ascontiguousarray(each, np.float64).tobytes() for each in (walls, discs))
        return _shared_grid(*arrays, (start[0], start[1]), farthest, open_reach)

    @property
    def diagonal(self) -> float:
        """The diagonal of the grid [m]: no two places are farther apart."""
        return math.hypot(*self._distances.shape) * self.resolution

    def distance(self, x: float, y: float) -> float:
        """A lower bound of a place's distance from obstacles [m]; 0 outside of the grid.

        Args:
            x: the place's x coordinate [m].
            y: the place's y coordinate [m].
        """
        column, row = np.floor((np.array([x, y]) - self._origin) / self.resolution).astype(int)
        rows, columns = self._distances.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return 0.0
        bound = float(self._distances[row, column]) - _HALF_DIAGONAL * self.resolution
        return max(0.0, bound)

    def free_space(self, clearance: float) -> FreeSpace:
        """The places that can be reached; computed once for each clearance.

        If the start's square is not free, the nearest free one is used. The result may be empty.

        Args:
            clearance: distance from all obstacles [m]: 0 or more, and at most `farthest`.

        Raises:
            UsageError: the clearance is not usable.
        """
        if not 0.0 <= clearance <= self.farthest:
            raise UsageError(
                f"expected a clearance of 0 to {self.farthest:g} m, found {clearance!r}"
            )
        if clearance not in self._spaces:
            free = self._distances >= clearance + _HALF_DIAGONAL * self.resolution
            reachable = _core.connected(free, self._nearest(free)) if free.any() else free
            self._spaces[clearance] = FreeSpace(
                reachable, self._origin, self.resolution, float(clearance)
            )
        return self._spaces[clearance]

    def _around(self, point: Point, reach: float) -> Tuple[FloatArray, FloatArray]:
        """The part of the distances within a square around a point.

        Args:
            point: x, y [m].
            reach: from the point to the sides of the square [m].

        Returns:
            A view of the distances; and those of the same squares from the point [m].
        """
        x, y = self._origin.tolist()
        rows = _span(point[1] - y, reach, self.resolution)
        columns = _span(point[0] - x, reach, self.resolution)
        window = self._distances[rows, columns]
        height, width = window.shape
        ys = (rows.start + 0.5 + np.arange(height))[:, None] * self.resolution + (y - point[1])
        xs = (columns.start + 0.5 + np.arange(width)) * self.resolution + (x - point[0])
        return window, np.sqrt(xs**2 + ys**2)

    def _nearest(self, free: BoolArray) -> Optional[Tuple[int, int]]:
        """The row and column of the free square that is nearest to the start."""
        if self._start is None:
            return None
        column, row = np.floor((self._start - self._origin) / self.resolution).astype(int).tolist()
        height, width = free.shape
        if 0 <= row < height and 0 <= column < width and free[row, column]:
            return row, column
        rows, columns = np.nonzero(free)
        squares = self._origin + (np.column_stack([columns, rows]) + 0.5) * self.resolution
        nearest = int(((squares - self._start) ** 2).sum(axis=1).argmin())
        return int(rows[nearest]), int(columns[nearest])


@lru_cache(maxsize=4)
def _shared_grid(
    walls: bytes, discs: bytes, start: Tuple[float, float], farthest: float, open_reach: float
) -> DistanceGrid:
    segments, circles = np.frombuffer(walls).reshape(-1, 4), np.frombuffer(discs).reshape(-1, 3)
    return DistanceGrid(segments, start, farthest, discs=circles, open_reach=open_reach)


def _span(middle: float, reach: float, resolution: float) -> slice:
    """The rows or columns from `reach` before a coordinate [m] to `reach` behind it."""
    first = math.floor((middle - reach) / resolution)
    last = math.ceil((middle + reach) / resolution)
    return slice(max(first, 0), max(last, 0))


def discs_of(models: Iterable[Tuple[Pose, float]]) -> FloatArray:
    """Obstacles from the poses and radii of models: shape (m, 3)."""
    return np.array([[pose.x, pose.y, radius] for pose, radius in models]).reshape(-1, 3)

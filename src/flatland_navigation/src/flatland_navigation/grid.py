"""A grid of the cells in which a robot's centre keeps its clearance from walls."""

from dataclasses import dataclass, replace
from typing import Optional, Tuple

import numpy as np

from flatland_server import BoolArray, FloatArray, Point, Segments, _core, from_segments
from flatland_server.array_math import is_enclosed

Cell = Tuple[int, int]
"""Row and column; the bottom left cell is (0, 0)."""

_MOST_CELLS = 20_000_000


@dataclass(frozen=True)
class Grid:
    """Free and blocked cells, in the frame of the walls.

    Attributes:
        free: by row and column, the bottom row first: whether all points of the cell have the
            clearance.
        resolution: side of a cell [m].
        origin: bottom left corner of the bottom left cell [m].
        clearance: distance [m] that the robot's centre must have from walls.
        walls: shape (n, 4), x1, y1, x2, y2 [m].
    """

    free: BoolArray
    resolution: float
    origin: Point
    clearance: float
    walls: Segments

    @classmethod
    def from_walls(cls, walls: Segments, clearance: float, resolution: float = 0.1) -> "Grid":
        """The grid that spans all walls.

        Args:
            walls: shape (n, 4), x1, y1, x2, y2 [m].
            clearance: distance [m] that the robot's centre must have from walls.
            resolution: side of a cell [m].

        Raises:
            ValueError: there are no walls, or so many cells that they would not fit in memory.
        """
        if len(walls) == 0:
            raise ValueError("expected a map with walls, found none")
        ends = walls.reshape(-1, 2)
        low, high = ends.min(axis=0), ends.max(axis=0)
        columns, rows = (int(n) for n in np.maximum(np.ceil((high - low) / resolution), 1))
        if rows * columns > _MOST_CELLS:
            raise ValueError(
                f"expected a map of at most {_MOST_CELLS} cells, found {columns} x {rows} cells "
                f"of {resolution:g} m: choose a coarser resolution"
            )
        free = np.ones((rows, columns), dtype=bool)
        grid = cls(free, resolution, (float(low[0]), float(low[1])), clearance, walls)
        grid._block(walls)
        return grid

    def encloses(self, point: Point, other: Point) -> bool:
        """True if closed walls lie around one of two points [m] alone, as around furniture."""
        walls = _closed(self.walls)
        return is_enclosed(point, walls) != is_enclosed(other, walls)

    def with_obstacles(self, points: FloatArray) -> "Grid":
        """A copy in which the cells around further points [m] are blocked: shape (n, 2)."""
        # One point of each small square represents the others in it.
        squares = np.unique(np.floor(points / (self.resolution / 2)), axis=0)
        centres = (squares + 0.5) * (self.resolution / 2)
        copy = replace(self, free=self.free.copy())
        copy._block(np.hstack([centres, centres]))
        return copy

    @property
    def bounds(self) -> Tuple[float, float, float, float]:
        """Least x, least y, greatest x, greatest y [m]."""
        rows, columns = self.free.shape
        x, y = self.origin
        return x, y, x + columns * self.resolution, y + rows * self.resolution

    def cell_of(self, point: Point) -> Optional[Cell]:
        """The cell with a point [m]; None outside of the grid."""
        row = int((point[1] - self.origin[1]) // self.resolution)
        column = int((point[0] - self.origin[0]) // self.resolution)
        rows, columns = self.free.shape
        return (row, column) if 0 <= row < rows and 0 <= column < columns else None

    def centre_of(self, cell: Cell) -> Point:
        """The middle of a cell [m]."""
        row, column = cell
        x, y = self.origin
        return x + (column + 0.5) * self.resolution, y + (row + 0.5) * self.resolution

    def is_free(self, point: Point) -> bool:
        """True if a point [m] is in a free cell."""
        cell = self.cell_of(point)
        return cell is not None and bool(self.free[cell])

    def line_is_free(self, start: Point, end: Point) -> bool:
        """True if a straight line [m] crosses free cells alone."""
        if self.cell_of(start) is None or self.cell_of(end) is None:
            return False
        a = (np.array(start) - self.origin) / self.resolution
        b = (np.array(end) - self.origin) / self.resolution
        # Between two crossings of cell borders, the line is in the cell of the middle.
        crossings = [np.array([0.0, 1.0])]
        for first, last in zip(a, b):
            borders = np.arange(np.ceil(min(first, last)), np.floor(max(first, last)) + 1)
            if first != last:
                crossings.append((borders - first) / (last - first))
        t = np.sort(np.concatenate(crossings))
        middles = (t[1:] + t[:-1]) / 2
        rows, columns = self.free.shape
        column = np.clip((a[0] + middles * (b[0] - a[0])).astype(int), 0, columns - 1)
        row = np.clip((a[1] + middles * (b[1] - a[1])).astype(int), 0, rows - 1)
        return bool(self.free[row, column].all())

    def nearest_free(self, point: Point, reach: float) -> Optional[Cell]:
        """The free cell with the nearest centre within a distance [m]; None if there is none."""
        row = (point[1] - self.origin[1]) / self.resolution
        column = (point[0] - self.origin[0]) / self.resolution
        cells = reach / self.resolution
        rows, columns = self.free.shape
        first_row, last_row = max(0, int(row - cells)), min(rows, int(row + cells) + 1)
        first, last = max(0, int(column - cells)), min(columns, int(column + cells) + 1)
        if first_row >= last_row or first >= last:
            return None
        corner = np.array([first_row, first])
        found = corner + np.argwhere(self.free[first_row:last_row, first:last])
        distances = np.hypot(found[:, 0] + 0.5 - row, found[:, 1] + 0.5 - column)
        if len(found) == 0 or distances.min() > cells:
            return None
        nearest = found[distances.argmin()]
        return int(nearest[0]), int(nearest[1])

    def distance_to_wall(self, point: Point) -> float:
        """Distance of a point to the nearest wall [m]."""
        away = from_segments(np.array([point]), self.walls)
        return float(np.hypot(away[..., 0], away[..., 1]).min())

    def _block(self, segments: Segments) -> None:
        """Blocks the cells with points nearer to a segment than the clearance."""
        # The points of a cell are at most half a diagonal from its centre.
        reach = self.clearance + self.resolution * np.sqrt(0.5)
        squares = np.full(self.free.shape, reach**2)
        segments = np.ascontiguousarray(segments, np.float64)
        _core.lower_to_walls(squares, segments, reach, self.origin, self.resolution)
        self.free[squares < reach**2] = False


def _closed(walls: Segments) -> Segments:
    """The walls without those that have a loose end, and those that then have one."""
    while True:
        ends = np.unique(np.round(walls.reshape(-1, 2), 6), axis=0, return_inverse=True)[1].ravel()
        is_loose = (np.bincount(ends) == 1)[ends].reshape(-1, 2).any(axis=1)
        if not is_loose.any():
            return walls
        walls = walls[~is_loose]

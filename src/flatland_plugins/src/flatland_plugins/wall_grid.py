"""Walls sorted into a grid, to find the nearest of many walls around many points."""

import math

import numpy as np

from flatland_plugins.social_force import Others, directions
from flatland_server import FloatArray, IntArray, Segments, from_segments

_FAR_AWAY = 1e9
"""Position of padding walls [m]: far enough to have no effect."""

_MOST_SIDES = 4
_ANOTHER_SIDE = math.cos(math.radians(80.0))
"""Two points of a wall count separately if they are seen more than 80 degrees apart.

On a straight wall, all points that far from the nearest one are more than 5 times as distant,
however many segments it is cut into; the walls of a right-angled corner both count.
"""


class WallGrid:
    """Finds the segments around points, among many.

    The segments are cut into pieces no longer than `reach`, which are sorted by the square cell
    that their middle lies in. A cell is 1.5 `reach` wide: what is within `reach` of a point has its
    middle in the point's cell or in one of the eight around it.

    Args:
        segments: the walls [m], shape (n, 4).
        reach: search distance around a point [m]; farther walls may be missed.
    """

    def __init__(self, segments: Segments, reach: float) -> None:
        self._cell = 1.5 * reach
        pieces = cut(segments, reach)
        cells = np.floor((pieces[:, :2] + pieces[:, 2:]) / 2.0 / self._cell).astype(np.int64)
        self._low = cells.min(axis=0, initial=0) - 1
        # An empty row and column around them, for points outside the grid.
        self._high = cells.max(axis=0, initial=0) + 1
        keys = self._keys_of(cells)
        order = np.argsort(keys, kind="stable")
        self._keys, self._pieces = keys[order], pieces[order]

    def _keys_of(self, cells: IntArray) -> IntArray:
        columns = self._high[1] - self._low[1] + 2
        return np.asarray((cells[..., 0] - self._low[0]) * columns + cells[..., 1] - self._low[1])

    def near(self, points: FloatArray) -> FloatArray:
        """The pieces around points (n, 2): shape (n, m, 4), filled up with far ones."""
        cells = np.floor(points / self._cell).astype(np.int64)
        cells = np.minimum(np.maximum(cells, self._low), self._high)
        rows = self._keys_of(cells[:, np.newaxis] + [[-1, 0], [0, 0], [1, 0]])
        first = np.searchsorted(self._keys, rows - 1, "left")
        counts = np.searchsorted(self._keys, rows + 1, "right") - first
        column = np.arange(counts.max(initial=0))
        is_there = column < counts[..., np.newaxis]
        found = np.full((*is_there.shape, 4), _FAR_AWAY)
        found[is_there] = self._pieces[(first[..., np.newaxis] + column)[is_there]]
        return found.reshape(len(points), 3 * len(column), 4)

    def walls(self, points: FloatArray) -> Others:
        """The walls around each point: the nearest point of them on up to four sides."""
        others = nearest(points, self.near(points))
        return sides(others) if others.distances.shape[1] else others


def cut(segments: Segments, longest: float) -> Segments:
    """The segments in equal pieces no longer than `longest`."""
    steps = segments[:, 2:] - segments[:, :2]
    counts = np.ceil(np.hypot(steps[:, 0], steps[:, 1]) / longest).astype(np.int64).clip(1)
    index = np.repeat(np.arange(len(segments)), counts)
    number = np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
    starts, steps = segments[index, :2], steps[index]
    begin, end = number / counts[index], (number + 1) / counts[index]
    return np.hstack([starts + begin[:, np.newaxis] * steps, starts + end[:, np.newaxis] * steps])


def nearest(points: FloatArray, segments: FloatArray) -> Others:
    """Distances of points (n, 2) from segments, (n, m, 4) or (m, 4) for all, and directions."""
    away, distances = directions(from_segments(points, segments))
    return Others(distances, away)


def sides(others: Others) -> Others:
    """The nearest of the others, the nearest in a clearly different direction, and so on.

    One point of a wall repels, however many pieces the wall is made of; but both walls of a
    corridor repel, and both corners of a door.
    """
    distances, away = others.distances.copy(), others.away
    persons = np.arange(len(distances))
    kept, kept_away = [], []
    for _ in range(_MOST_SIDES):
        index = distances.argmin(axis=1)
        kept.append(distances[persons, index])
        kept_away.append(away[persons, index])
        is_same_side = np.einsum("nmi,ni->nm", away, kept_away[-1]) > _ANOTHER_SIDE
        distances[is_same_side] = np.inf
        distances[persons, index] = np.inf  # also a point on the wall, which has no direction
    return Others(np.stack(kept, axis=1), np.stack(kept_away, axis=1))

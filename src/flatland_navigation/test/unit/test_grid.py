"""Grids: which cells are free, against distances that are computed point by point."""

import math
import zlib

import numpy as np
import pytest

from flatland_navigation.grid import Grid
from flatland_navigation.parameters import read_walls
from flatland_server.config.worlds import shipped_worlds

ROOM = np.array([[0.0, 0, 4, 0], [4, 0, 4, 3], [4, 3, 0, 3], [0, 3, 0, 0]])


def distance(point, walls):
    """Distance of a point to the nearest of many points on the walls."""
    t = np.linspace(0.0, 1.0, 2001)[:, np.newaxis, np.newaxis]
    points = walls[:, :2] + t * (walls[:, 2:] - walls[:, :2])
    return np.hypot(points[..., 0] - point[0], points[..., 1] - point[1]).min()


def test_all_points_of_free_cells_have_the_clearance():
    rng = np.random.default_rng(1)
    walls = np.vstack([ROOM, rng.uniform(0.5, 2.5, (2, 4))])
    grid = Grid.from_walls(walls, 0.25, 0.1)

    for row, column in np.ndindex(grid.free.shape):
        x, y = grid.centre_of((row, column))
        corners = [(x + i, y + j) for i in (-0.05, 0.05) for j in (-0.05, 0.05)]
        if grid.free[row, column]:
            assert min(distance(corner, walls) for corner in corners) >= 0.25
        else:
            assert distance((x, y), walls) < 0.25 + 0.1 * math.sqrt(0.5) + 1e-3


def test_grids_of_the_shipped_worlds_stay_the_same():
    free = {}
    for name, path in shipped_worlds().items():
        grid = Grid.from_walls(read_walls(path), 0.24)
        free[name] = int(grid.free.sum()), zlib.crc32(np.packbits(grid.free))

    assert free == {
        "circle_crossing": (12996, 2744295022),
        "corridor_frontal": (2926, 2405919019),
        "crossing": (12996, 2744295022),
        "doorway": (5760, 2295281885),
        "intersection": (21624, 2926547506),
        "office": (76312, 467121480),
        "overtaking": (2926, 2405919019),
        "racetrack": (46481, 512349358),
        "test_room": (5076, 154564600),
    }


def test_a_grid_spans_the_walls():
    grid = Grid.from_walls(ROOM - 1.0, 0.2, 0.1)

    assert grid.free.shape == (30, 40)
    assert grid.bounds == pytest.approx((-1, -1, 3, 2))
    assert grid.cell_of((-0.95, -0.85)) == (1, 0)
    assert grid.cell_of((3.2, 0.0)) is None
    assert grid.is_free((1.0, 0.5))
    assert not grid.is_free((-0.9, 0.5))


def test_a_line_is_free_if_all_its_cells_are():
    rng = np.random.default_rng(2)
    grid = Grid.from_walls(ROOM, 0.0, 0.1)
    grid.free[:] = rng.random(grid.free.shape) > 0.02

    for _ in range(300):
        start, end = rng.uniform(0.01, [3.99, 2.99], (2, 2))
        points = start + np.linspace(0, 1, 20_000)[:, np.newaxis] * (end - start)
        cells = (points / 0.1).astype(int)
        expected = grid.free[cells[:, 1], cells[:, 0]].all()
        assert grid.line_is_free(tuple(start), tuple(end)) == expected


def test_a_line_beyond_the_grid_is_not_free():
    grid = Grid.from_walls(ROOM, 0.1, 0.1)

    assert not grid.line_is_free((2.0, 1.5), (5.0, 1.5))


def test_obstacles_block_a_copy():
    grid = Grid.from_walls(ROOM, 0.2, 0.1)
    blocked = grid.with_obstacles(np.array([[2.0, 1.5], [2.001, 1.5]]))

    assert grid.is_free((2.0, 1.5))
    assert not blocked.is_free((2.0, 1.5))
    assert not blocked.is_free((2.15, 1.5))
    assert blocked.is_free((2.4, 1.5))
    assert grid.with_obstacles(np.empty((0, 2))).free.tolist() == grid.free.tolist()


def test_the_nearest_free_cell():
    grid = Grid.from_walls(ROOM, 0.2, 0.1)

    assert grid.nearest_free((0.05, 1.55), 0.5) == (15, 3)
    assert grid.nearest_free((0.05, 1.55), 0.2) is None
    assert grid.nearest_free((-3.0, 1.5), 0.5) is None


def test_a_map_without_walls_or_too_large_is_refused():
    with pytest.raises(ValueError, match="found none"):
        Grid.from_walls(np.empty((0, 4)), 0.2, 0.1)
    with pytest.raises(ValueError, match="choose a coarser resolution"):
        Grid.from_walls(ROOM * 1e4, 0.2, 0.01)

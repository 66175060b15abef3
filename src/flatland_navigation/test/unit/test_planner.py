"""Paths: as short as another algorithm's, clear of walls, and reasons where there is none."""

import math

import numpy as np
import pytest

from flatland_navigation.grid import Grid
from flatland_navigation.planner import PlanningError, plan, shortcut, shortest_path

ROOM = np.array([[0.0, 0, 6, 0], [6, 0, 6, 4], [6, 4, 0, 4], [0, 4, 0, 0]])
PARTITION = np.array([[3.0, 0, 3, 3]])
NICHE = np.array(
    [[4.7, 4.0, 4.7, 3.7], [4.7, 3.4, 4.7, 2.7], [4.7, 2.7, 6, 2.7]]
)  # too narrow to enter
CELL = np.array([[4.0, 1, 5, 1], [5, 1, 5, 2], [5, 2, 4, 2], [4, 2, 4, 1]])


def shortest_lengths(free, start):
    """Lengths of the shortest paths to all cells, by relaxing all steps until nothing changes."""
    lengths = np.full(free.shape, np.inf)
    lengths[start] = 0.0
    rows, columns = free.shape
    steps = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    before = None
    while before is None or (lengths != before).any():
        before = lengths.copy()
        for row, column in np.argwhere(free):
            for i, j in steps:
                r, c = row + i, column + j
                if not (0 <= r < rows and 0 <= c < columns and free[r, c]):
                    continue
                if i and j and not (free[row, c] and free[r, column]):
                    continue
                new = lengths[r, c] + math.hypot(i, j)
                lengths[row, column] = min(lengths[row, column], new)
    return lengths


def length_of(cells):
    return sum(math.dist(a, b) for a, b in zip(cells, cells[1:]))


@pytest.mark.parametrize("seed", range(6))
def test_paths_are_as_short_as_those_of_another_algorithm(seed):
    rng = np.random.default_rng(seed)
    free = rng.random((12, 15)) > (0.25, 0.4)[seed % 2]
    free[5, 5] = True
    lengths = shortest_lengths(free, (5, 5))

    for cell in map(tuple, np.argwhere(free)):
        path = shortest_path(free, (5, 5), cell)
        if not path:
            assert lengths[cell] == math.inf
            continue
        assert (path[0], path[-1]) == ((5, 5), cell)
        assert all(free[c] for c in path)
        assert max(math.dist(a, b) for a, b in zip(path, [*path[1:], path[-1]])) < 1.5
        assert length_of(path) == pytest.approx(lengths[cell])


def test_a_diagonal_step_does_not_cut_a_corner():
    free = np.array([[True, False], [True, True]])

    assert shortest_path(free, (0, 0), (1, 1)) == [(0, 0), (1, 0), (1, 1)]
    assert shortest_path(np.eye(2, dtype=bool), (0, 0), (1, 1)) == []


def test_a_path_around_a_partition_is_tight_and_clear():
    walls = np.vstack([ROOM, PARTITION])
    grid = Grid.from_walls(walls, 0.25, 0.1)

    path = plan(grid, (1.0, 1.0), (5.0, 1.0))

    assert path[0].tolist() == [1.0, 1.0]
    assert path[-1].tolist() == [5.0, 1.0]
    assert len(path) <= 5
    # The shortest path that keeps 0.25 m from the partition's end, (3, 3): two tangents, one arc.
    beside = math.asin(0.25 / math.sqrt(8.0))
    shortest = 2 * math.sqrt(8.0 - 0.25**2) + 0.25 * (math.pi / 2 + 2 * beside)
    length = np.hypot(*np.diff(path, axis=0).T).sum()
    assert shortest < length < 1.06 * shortest
    points = np.concatenate([np.linspace(a, b, 200) for a, b in zip(path, path[1:])])
    assert min(grid.distance_to_wall(tuple(point)) for point in points) >= 0.25


def test_a_straight_path_has_no_corners():
    grid = Grid.from_walls(ROOM, 0.25, 0.1)

    assert plan(grid, (1.0, 1.0), (5.0, 2.3)).tolist() == [[1.0, 1.0], [5.0, 2.3]]


def test_a_shortcut_keeps_the_ends():
    grid = Grid.from_walls(ROOM, 0.25, 0.1)
    path = np.array([[1.0, 1], [1, 3], [5, 3], [5, 1]])

    assert shortcut(grid, path).tolist() == [[1.0, 1.0], [5.0, 1.0]]
    assert shortcut(grid, path[:2]).tolist() == path[:2].tolist()


def test_a_start_beside_a_wall_is_left_on_a_straight_line():
    grid = Grid.from_walls(np.vstack([ROOM, PARTITION]), 0.25, 0.1)

    path = plan(grid, (2.85, 1.55), (1.0, 1.0))

    assert path[0].tolist() == [2.85, 1.55]
    assert path[1] == pytest.approx([2.65, 1.55])  # on the same side of the partition


@pytest.mark.parametrize(
    ("start", "goal", "reason"),
    [
        ((1, 1), (7, 1), r"\(7.00, 1.00\) is outside of the map, which spans x from 0 to 6"),
        ((1, 1), (5.9, 1), r"\(5.90, 1.00\) is 0.10 m from a wall; .* at least 0.25 m"),
        ((1, 1), (4.5, 1.5), r"\(4.50, 1.50\) is inside an obstacle"),
        ((1, 1), (4.1, 1.1), r"\(4.10, 1.10\) is inside an obstacle"),
        ((1, 1), (3.9, 1.5), r"is 0.10 m from a wall"),
        ((1, 1), (2.1, 1), r"is 0.10 m from a wall"),  # behind a wall that is open
        ((1, 1), (5.5, 3.5), r"no path from \(1.00, 1.00\) to \(5.50, 3.50\)"),
        ((-1, 1), (1, 1), r"the robot is outside of the map, at \(-1.00, 1.00\)"),
    ],
)
def test_a_goal_that_cannot_be_reached_has_a_reason(start, goal, reason):
    grid = Grid.from_walls(np.vstack([ROOM, CELL, PARTITION - [1, 0, 1, 0], NICHE]), 0.25, 0.1)

    with pytest.raises(PlanningError, match=reason):
        plan(grid, start, goal)

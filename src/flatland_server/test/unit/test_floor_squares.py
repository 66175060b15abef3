"""Squares of a floor: the numbers that NumPy gives, to the last bit."""

import math

import numpy as np
import pytest

from flatland_server import _core

CORNER, SIDE = (-3.3, 1.7), 0.07


def floor(count, seed=0):
    """Some of 900 x 700 squares, and their columns and rows."""
    reachable = np.zeros((700, 900), bool)
    reachable.flat[np.random.default_rng(seed).choice(reachable.size, count, replace=False)] = True
    rows, columns = np.nonzero(reachable)
    return _core.FloorSquares(reachable, CORNER, SIDE), columns, rows


@pytest.mark.parametrize("kind", ["PCG64", "PCG64DXSM", "MT19937", "Philox", "SFC64"])
def test_points_are_drawn_as_numpy_draws_them(kind):
    ours, numpys = (np.random.Generator(getattr(np.random, kind)(5)) for _ in range(2))
    for count in (1, 2, 3, 1000, 600_000):
        squares, columns, rows = floor(count)
        assert len(squares) == count
        for _ in range(5):
            chosen = numpys.integers(count)
            x, y = numpys.random(2).tolist()
            expected = (
                CORNER[0] + (int(columns[chosen]) + x) * SIDE,
                CORNER[1] + (int(rows[chosen]) + y) * SIDE,
            )
            point = squares.draw(ours)
            assert point == expected
            assert point in squares
    assert ours.random() == numpys.random()


def is_clear(point, discs, radius):
    return all(np.hypot(point[0] - x, point[1] - y) > radius + r for x, y, r in discs)


def discs(count):
    return [(*np.random.default_rng(count).uniform(0, 50, 2).tolist(), 6.0) for _ in range(count)]


def test_clear_poses_equal_repeated_draws_without_overlaps():
    squares, ours, draws = floor(5000)[0], np.random.default_rng(1), np.random.default_rng(1)
    found = set()
    for tries in (1, 2, 3, 50):
        for _ in range(10):
            others, expected = discs(10), []
            for _ in range(4):
                points = (squares.draw(draws) for _ in range(tries))
                point = next((each for each in points if is_clear(each, others, 3.0)), None)
                expected.append(point and (*point, math.tau * draws.random() - math.pi))
                others += [(*point, 5.0)] if point else []
            assert squares.draw_clear(ours, discs(10), 5.0, 3.0, 4, tries) == expected
            found.update(pose is not None for pose in expected)
    assert ours.random() == draws.random()
    assert found == {False, True}


def ends_in_python(squares, rng, start, goal, distances, radius, at_starts, at_goals, tries):
    least, largest = distances

    def around(x, y):
        distance = math.sqrt(least**2 + float(rng.random()) * (largest**2 - least**2))
        bearing = math.tau * float(rng.random())
        return x + distance * math.cos(bearing), y + distance * math.sin(bearing)

    for _ in range(tries):
        yaw = math.tau * float(rng.random()) - math.pi
        first = start or (around(*goal) if goal else squares.draw(rng))
        last = goal or around(*first)
        if not start and not (first in squares and is_clear(first, at_starts, radius)):
            continue
        if goal or (last in squares and is_clear(last, at_goals, radius)):
            return (*first, yaw), last
    return None


@pytest.mark.parametrize("start", [None, (20.0, 20.0)])
@pytest.mark.parametrize("goal", [None, (25.0, 31.0)])
def test_start_and_goal_equal_repeated_draws_that_fit(start, goal):
    squares, ours, draws = floor(300_000)[0], np.random.default_rng(1), np.random.default_rng(1)
    found = 0
    for tries in (1, 3, 500):
        for _ in range(40):
            rest = start, goal, (3.3, 11.1), 0.7, discs(5), discs(3), tries
            ends = squares.draw_ends(ours, *rest)
            assert ends == ends_in_python(squares, draws, *rest)
            found += ends is not None
    assert found > 40
    assert ours.random() == draws.random()


def squared_distances(xs, ys, along_x, along_y):
    """Of points from a segment: all are relative to one of its ends."""
    square = along_x**2 + along_y**2 or 1.0
    part = np.clip(along_x / square * xs + along_y / square * ys, 0.0, 1.0)
    return (xs - part * along_x) ** 2 + (ys - part * along_y) ** 2


def test_distances_from_walls_are_those_of_numpy():
    rng = np.random.default_rng(3)
    walls = np.concatenate([rng.uniform(-5, 20, (9, 4)), [[4, 4, 4, 4], [0, 9, 10, 9]]])
    ours = np.full((250, 300), 9.0)
    xs, ys = (np.arange(300) + 0.5) * SIDE, (np.arange(250)[:, None] + 0.5) * SIDE
    expected = ours.copy()
    for x1, y1, x2, y2 in walls.tolist():
        x, y = xs + (CORNER[0] - x1), ys + (CORNER[1] - y1)
        np.minimum(expected, squared_distances(x, y, x2 - x1, y2 - y1), out=expected)
    _core.lower_to_walls(ours, walls, 3.0, CORNER, SIDE)
    np.testing.assert_array_equal(ours, expected)
    assert (ours < 9.0).mean() > 0.3


def test_connected_cells_go_around_corners_not_through_walls():
    rows = ["..#....", ".##.##.", "....#..", "#####.#", ".......", "######."]
    free = np.array([[pixel == "." for pixel in row] for row in rows])

    assert _core.connected(free, (0, 0)).tolist() == [
        [pixel == "." for pixel in row] for row in rows
    ]
    free[3, 5] = False
    assert not _core.connected(free, (0, 0))[4:].any()
    upper = free.copy()
    upper[4:] = False
    assert np.array_equal(_core.connected(free, None), upper)  # the larger of two parts
    assert not _core.connected(np.zeros((2, 2), bool), None).any()


def test_wrong_arguments_are_refused():
    with pytest.raises(ValueError, match=r"expected squares \(rows, columns\)"):
        _core.FloorSquares(np.zeros(2, bool), CORNER, SIDE)
    with pytest.raises(ValueError, match="there is no square"):
        floor(0)[0].draw(np.random.default_rng())
    with pytest.raises(AttributeError):
        floor(3)[0].draw(5)
    with pytest.raises(ValueError, match=r"segments must be an array of shape \(n, 4\)"):
        _core.lower_to_walls(np.zeros((2, 2)), np.zeros((3, 2)), 1.0, CORNER, SIDE)
    for outside in ((-1, 0), (0, 3), (2, 0)):
        with pytest.raises(ValueError, match="and one of them"):
            _core.connected(np.ones((2, 3), bool), outside)

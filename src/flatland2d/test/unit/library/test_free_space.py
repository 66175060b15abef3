"""Free space: against the exact distance of points from obstacles."""

import pickle

import numpy as np
import pytest

from flatland2d import DistanceGrid, UsageError


def distance(point, walls):
    """The distance from a point to the nearest of some segments [m]."""
    a, b = walls[:, :2], walls[:, 2:]
    along = b - a
    t = np.clip(((point - a) * along).sum(1) / (along**2).sum(1), 0, 1)
    return np.linalg.norm(point - (a + t[:, None] * along), axis=1).min()


def room(low, high):
    corners = [(low, low), (high, low), (high, high), (low, high)]
    return np.array([[*a, *b] for a, b in zip(corners, corners[1:] + corners[:1])], float)


def test_poses_need_a_generator_and_a_free_place():
    grid = DistanceGrid(room(-5, 5), (0.0, 0.0), 9.0)
    with pytest.raises(UsageError, match=r"rng as a numpy\.random\.Generator .*, found 5"):
        grid.free_space(0.3).poses(3, 5)
    with pytest.raises(UsageError, match="no place is free and can be reached"):
        grid.free_space(8.0).poses(3, np.random.default_rng(1))


def test_points_are_as_far_from_walls_as_they_should_be():
    rng = np.random.default_rng(1)
    walls = np.concatenate([room(-5, 5), rng.uniform(-5, 5, (6, 4))])
    grid = DistanceGrid(walls, (0.0, 0.0), 1.0)
    for clearance in (0.1, 0.37, 0.9):
        space = grid.free_space(clearance)
        points = [space.point(rng) for _ in range(500)]
        distances = [distance(np.array(point), walls) for point in points]
        assert min(distances) >= clearance
        assert min(distances) < clearance + 0.1  # within the grid's resolution
        assert all(space.contains_point(*point) for point in points)
        assert space.contains(np.array(points)).all()
        copied = pickle.loads(pickle.dumps(space))
        again = copied.point(np.random.default_rng(1)), copied.area, copied.clearance
        assert again == (space.point(np.random.default_rng(1)), space.area, clearance)


def test_distances_are_lower_bounds_up_to_the_farthest():
    rng = np.random.default_rng(2)
    walls = np.concatenate([room(-5, 5), rng.uniform(-5, 5, (6, 4))])
    grid = DistanceGrid(walls, (0.0, 0.0), 0.8, discs=np.array([[2.0, 2.0, 0.7]]))
    for x, y in rng.uniform(-5, 5, (300, 2)):
        exact = min(distance(np.array([x, y]), walls), np.hypot(x - 2, y - 2) - 0.7, 0.8)
        assert max(0.0, exact - 0.08) <= grid.distance(x, y) <= max(0.0, exact) + 1e-12


def test_free_space_behind_walls_is_left_out():
    walls = np.concatenate([room(-5, 5), [[1.0, -5, 1.0, 5]]])
    grid = DistanceGrid(walls, (-2.0, 0.0), 0.5)
    space, rng = grid.free_space(0.3), np.random.default_rng(1)
    assert space.poses(500, rng)[:, 0].max() < 0.7
    assert not space.contains_point(3.0, 0.0)
    assert not space.contains_point(30.0, 0.0)
    assert grid.distance(3.0, 0.0) > 0.3
    assert grid.distance(30.0, 0.0) == 0.0
    assert grid.free_space(0.3) is space


def test_a_gap_counts_if_the_disc_fits_through():
    walls = np.concatenate([room(-5, 5), [[1.0, -5, 1.0, -0.5], [1.0, 0.5, 1.0, 5]]])
    grid = DistanceGrid(walls, (-2.0, 0.0), 1.0)
    assert grid.free_space(0.4).contains_point(3.0, 0.0)
    assert not grid.free_space(0.55).contains_point(3.0, 0.0)


def test_without_walls_free_space_is_a_square_or_an_error():
    grid = DistanceGrid(np.empty((0, 4)), (100.0, 50.0), 0.5, open_reach=10.0)
    points = grid.free_space(0.3).poses(500, np.random.default_rng(1))[:, :2]
    assert np.abs(points - (100, 50)).max() == pytest.approx(10, abs=0.2)
    with pytest.raises(UsageError, match="no walls that bound its free space"):
        DistanceGrid(np.empty((0, 4)), (100.0, 50.0), 0.5)
    for wrong in (-0.1, 0.6, float("nan")):
        with pytest.raises(UsageError, match=r"expected a clearance of 0 to 0\.5 m, found"):
            grid.free_space(wrong)

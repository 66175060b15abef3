"""Free space: against the exact distance of points from walls."""

import numpy as np
import pytest

from flatland_gym.free_space import FreeSpace


def distance(point, walls):
    """From a point to the nearest of some segments [m]."""
    a, b = walls[:, :2], walls[:, 2:]
    along = b - a
    t = np.clip(((point - a) * along).sum(1) / (along**2).sum(1), 0, 1)
    return np.linalg.norm(point - (a + t[:, None] * along), axis=1).min()


def room(low, high):
    corners = [(low, low), (high, low), (high, high), (low, high)]
    return np.array([[*a, *b] for a, b in zip(corners, corners[1:] + corners[:1])], float)


def test_points_are_as_far_from_walls_as_they_should_be():
    rng = np.random.default_rng(1)
    walls = np.concatenate([room(-5, 5), rng.uniform(-5, 5, (6, 4))])
    space = FreeSpace(walls, (0.0, 0.0), 1.0)
    for radius in (0.1, 0.37, 0.9):
        cells = space.cells(radius)
        points = [space.draw_point(cells, rng) for _ in range(500)]
        distances = [distance(np.array(point), walls) for point in points]
        assert min(distances) > radius
        assert min(distances) < radius + 0.2  # and no farther than the grid is coarse
        assert all(space.contains(cells, *point) for point in points)


def test_what_walls_separate_is_left_out():
    walls = np.concatenate([room(-5, 5), [[1.0, -5, 1.0, 5]]])
    space = FreeSpace(walls, (-2.0, 0.0), 0.5)
    cells, rng = space.cells(0.3), np.random.default_rng(1)
    points = np.array([space.draw_point(cells, rng) for _ in range(500)])
    assert points[:, 0].max() < 0.7
    assert not space.contains(cells, 3.0, 0.0)
    assert not space.contains(cells, 30.0, 0.0)
    assert space.clearance(3.0, 0.0) > 0.3
    assert space.clearance(30.0, 0.0) == 0.0


def test_a_gap_counts_if_the_disc_fits_through():
    walls = np.concatenate([room(-5, 5), [[1.0, -5, 1.0, -0.5], [1.0, 0.5, 1.0, 5]]])
    space = FreeSpace(walls, (-2.0, 0.0), 1.0)
    assert space.contains(space.cells(0.3), 3.0, 0.0)
    assert not space.contains(space.cells(0.55), 3.0, 0.0)


def test_without_walls_it_is_a_square_around_the_robot():
    space = FreeSpace(np.empty((0, 4)), (100.0, 50.0), 0.5)
    cells, rng = space.cells(0.3), np.random.default_rng(1)
    points = np.array([space.draw_point(cells, rng) for _ in range(500)])
    assert np.abs(points - (100, 50)).max() == pytest.approx(10, abs=0.2)

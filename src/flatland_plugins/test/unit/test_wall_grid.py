"""The nearest walls, found through the grid and by looking at all of them."""

import math

import numpy as np
import pytest

from flatland_plugins.wall_grid import WallGrid, cut, nearest, sides

CORRIDOR = [[-50.0, 1.0, 50.0, 1.0], [-50.0, -0.5, 50.0, -0.5]]


def around(segments, point, reach=5.0):
    """The sides on which a point feels walls: (distance, direction away from it [rad])."""
    walls = WallGrid(np.array(segments), reach).walls(np.array([point]))
    return [
        (distance, math.atan2(*away[::-1]))
        for distance, away in zip(walls.distances[0], walls.away[0])
        if distance <= reach
    ]


@pytest.mark.parametrize(
    ("point", "distance", "away"),
    [
        pytest.param((1.0, 0.5), 0.5, (0.0, 1.0), id="above it"),
        pytest.param((1.5, -2.0), 2.0, (0.0, -1.0), id="below it"),
        pytest.param((-3.0, 4.0), 5.0, (-0.6, 0.8), id="before its beginning"),
        pytest.param((5.0, -4.0), 5.0, (0.6, -0.8), id="beyond its end"),
    ],
)
def test_the_nearest_point_of_a_wall(point, distance, away):
    wall = np.array([[0.0, 0.0, 2.0, 0.0]])

    others = nearest(np.array([point]), wall)

    assert others.distances == pytest.approx(np.array([[distance]]))
    assert others.away == pytest.approx(np.array([[away]]))


def test_a_segment_without_length_is_a_point():
    others = nearest(np.array([[3.0, 4.0]]), np.array([[0.0, 0.0, 0.0, 0.0]]))

    assert others.distances == pytest.approx(np.array([[5.0]]))


def test_walls_are_cut_into_equal_pieces():
    walls = np.array([[0.0, 0.0, 3.0, 4.0], [1.0, 1.0, 1.0, 2.0]])

    pieces = cut(walls, 2.0)

    assert pieces == pytest.approx(
        np.array(
            [[0, 0, 1, 4 / 3], [1, 4 / 3, 2, 8 / 3], [2, 8 / 3, 3, 4], [1, 1, 1, 2]]
        )
    )  # fmt: skip


@pytest.mark.parametrize("middle", [(0.0, 0.0), (1234.0, -56.0), (-3000.0, 700.0)])
def test_the_grid_finds_what_is_within_reach_of_any_point(middle):
    rng = np.random.default_rng(2)
    starts = rng.uniform(-20, 20, (500, 2)) + middle
    segments = np.hstack([starts, starts + rng.normal(0.0, 2.0, (500, 2))])
    points = rng.uniform(-30, 30, (1000, 2)) + middle
    grid = WallGrid(segments, 1.5)

    found = nearest(points, grid.near(points)).distances.min(axis=1)

    all_of_them = nearest(points, segments).distances.min(axis=1)
    is_within_reach = all_of_them <= 1.5
    assert 300 < is_within_reach.sum() < 900
    assert found[is_within_reach] == pytest.approx(all_of_them[is_within_reach], abs=1e-9)


def test_the_grid_leaves_out_what_is_far_away():
    grid = WallGrid(np.array([[x, 0.0, x + 0.1, 0.0] for x in np.arange(0.0, 1000.0, 0.1)]), 1.0)

    found = grid.near(np.array([[500.0, 0.0]]))

    assert (found[..., 0] < 1e6).sum() <= 3 * 1.5 / 0.1 + 2


@pytest.mark.parametrize("pieces", [1, 7, 1000])
def test_a_straight_wall_is_felt_once_into_how_many_segments_it_may_be_cut(pieces):
    ends = np.linspace(-10.0, 10.0, pieces + 1)
    wall = [[a, 2.0, b, 2.0] for a, b in zip(ends[:-1], ends[1:])]

    found = around(wall, (0.3, 1.0))

    assert found[0] == pytest.approx((1.0, -math.pi / 2))
    assert all(distance > 5.0 for distance, _ in found[1:])


CORNER = [[0.0, 0.0, 9.0, 0.0], [0.0, 0.0, 0.0, 9.0]]
DOOR = [[0.0, -9.0, 0.0, -0.5], [0.0, 0.5, 0.0, 9.0]]


@pytest.mark.parametrize(
    ("walls", "point", "first", "second"),
    [
        (CORRIDOR, (3.0, 0.0), (0.5, math.pi / 2), (1.0, -math.pi / 2)),
        (CORNER, (0.4, 0.6), (0.4, 0.0), (0.6, math.pi / 2)),
        (
            DOOR,
            (-0.3, 0.1),
            (0.5, math.atan2(-0.4, -0.3)),
            (math.hypot(0.3, 0.6), math.atan2(0.6, -0.3)),
        ),
    ],
    ids=["corridor", "corner", "door"],
)
def test_both_walls_are_felt(walls, point, first, second):
    assert around(walls, point)[:2] == [pytest.approx(first), pytest.approx(second)]


def test_where_there_is_no_wall_none_is_felt():
    assert around(np.empty((0, 4)), (1.0, 2.0)) == []
    assert around(CORRIDOR, (3.0, 2000.0)) == []
    assert around(CORRIDOR, (-2000.0, 0.0)) == []


def test_on_the_wall_itself_there_is_no_direction_away():
    walls = nearest(np.array([[1.0, 1.0]]), np.array(CORRIDOR))

    found = sides(walls)

    assert found.distances[0][:2] == pytest.approx([0.0, 1.5])
    assert found.away[0][:2] == pytest.approx(np.array([[0.0, 0.0], [0.0, 1.0]]))

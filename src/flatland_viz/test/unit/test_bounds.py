"""The extent of a world, and the view of it."""

import pytest

from flatland_viz.bounds import Bounds, around, bounds_in, extent, framed, grid_around


def test_the_bounding_box_of_walls():
    assert bounds_in("-3.5 -0.25 1 4") == Bounds(-3.5, -0.25, 1.0, 4.0)


def test_without_walls_there_is_no_box():
    assert bounds_in("") is None


def test_the_bounding_box_of_boxes():
    assert around([Bounds(0, 0, 1, 1), None, Bounds(-2, 0.5, 0, 3)]) == Bounds(-2, 0, 1, 3)


def test_a_world_without_walls_is_ten_metres_wide():
    assert around([]) == around([None]) == Bounds(-5, -5, 5, 5)


@pytest.mark.parametrize(
    ("walls", "models", "expected"),
    [
        pytest.param(Bounds(0, 0, 4, 3), None, Bounds(0, 0, 4, 3), id="no models"),
        pytest.param(
            Bounds(0, 0, 4, 3), Bounds(1, 2, 6, 2.5), Bounds(0, 0, 6, 3), id="a model outside"
        ),
        pytest.param(
            None, Bounds(29.8, 19.8, 60.2, 21.2), Bounds(29.8, 15.5, 60.2, 25.5), id="no walls"
        ),
        pytest.param(None, None, Bounds(-5, -5, 5, 5), id="empty"),
    ],
)
def test_a_world_is_its_walls_and_its_models(walls, models, expected):
    assert extent(walls, models) == pytest.approx(expected)


@pytest.mark.parametrize(
    "bounds",
    [
        pytest.param(Bounds(-10.0, -1.0, 90.0, 1.0), id="wide"),
        pytest.param(Bounds(-1.0, -10.0, 1.0, 90.0), id="high"),
        pytest.param(Bounds(-32.5, -12.5, 32.5, 12.5), id="the office"),
        pytest.param(Bounds(100.0, 100.0, 102.0, 101.0), id="small and far away"),
    ],
)
@pytest.mark.parametrize("size", [(1280, 716), (1024, 600), (500, 900)])
def test_the_view_is_filled_by_the_world(bounds, size):
    view = framed(bounds, *size)

    assert view.x == (bounds.min_x + bounds.max_x) / 2
    assert view.y == (bounds.min_y + bounds.max_y) / 2
    # The scale is in pixels a metre.
    across, along = view.scale * bounds.width / size[0], view.scale * bounds.height / size[1]
    assert max(across, along) == pytest.approx(0.92)


@pytest.mark.parametrize("bounds", [Bounds(3, 4, 3, 4), Bounds(3, 4, 3.1, 4)])
def test_the_zoom_on_a_point_is_limited(bounds):
    assert framed(bounds, 1000, 1000).scale == pytest.approx(0.92 * 1000 / 0.5)


@pytest.mark.parametrize(
    ("bounds", "cell_size"),
    [
        (Bounds(-1, -1, 1, 1), 1.0),
        (Bounds(-32.4, -12.6, 32.4, 12.6), 1.0),
        (Bounds(0, 0, 100.2, 3), 10.0),
        (Bounds(-3000, 500, 9000, 600), 1000.0),
    ],
)
def test_the_grid_covers_the_world_with_whole_cells(bounds, cell_size):
    grid = grid_around(bounds)

    half = grid.cells * grid.cell_size / 2
    assert grid.cell_size == cell_size
    assert grid.cells <= 200
    assert grid.x - half < bounds.min_x
    assert grid.y - half < bounds.min_y
    assert bounds.max_x < grid.x + half
    assert bounds.max_y < grid.y + half
    assert (grid.x - half) % grid.cell_size == 0
    assert (grid.y - half) % grid.cell_size == 0

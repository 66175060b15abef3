"""The extent of a world, and the view of it."""

import pytest
from python_qt_binding.QtCore import QRectF

from flatland_viz.bounds import extent, framed, grid_around


def box(min_x, min_y, max_x, max_y):
    return QRectF(min_x, min_y, max_x - min_x, max_y - min_y)


@pytest.mark.parametrize(
    ("walls", "models", "expected"),
    [
        pytest.param(box(0, 0, 4, 3), QRectF(), box(0, 0, 4, 3), id="no models"),
        pytest.param(box(0, 0, 4, 3), box(1, 2, 6, 2.5), box(0, 0, 6, 3), id="a model outside"),
        pytest.param(box(1, 0, 1, 3), QRectF(), box(1, 0, 1, 3), id="one wall"),
        pytest.param(QRectF(), box(30, 19.5, 60, 21.5), box(30, 15.5, 60, 25.5), id="no walls"),
        pytest.param(QRectF(), QRectF(), box(-5, -5, 5, 5), id="empty"),
    ],
)
def test_a_world_is_its_walls_and_its_models(walls, models, expected):
    assert extent(walls, models) == expected


@pytest.mark.parametrize(
    "bounds",
    [
        pytest.param(box(-10.0, -1.0, 90.0, 1.0), id="wide"),
        pytest.param(box(-1.0, -10.0, 1.0, 90.0), id="high"),
        pytest.param(box(-32.5, -12.5, 32.5, 12.5), id="the office"),
        pytest.param(box(100.0, 100.0, 102.0, 101.0), id="small and far away"),
    ],
)
@pytest.mark.parametrize("size", [(1280, 716), (1024, 600), (500, 900)])
def test_the_view_is_filled_by_the_world(bounds, size):
    view = framed(bounds, *size)

    assert (view.x, view.y) == (bounds.center().x(), bounds.center().y())
    # The scale is in pixels a metre.
    across, along = view.scale * bounds.width() / size[0], view.scale * bounds.height() / size[1]
    assert max(across, along) == pytest.approx(0.92)


@pytest.mark.parametrize("bounds", [box(3, 4, 3, 4), box(3, 4, 3.1, 4)])
def test_the_zoom_on_a_point_is_limited(bounds):
    assert framed(bounds, 1000, 1000).scale == pytest.approx(0.92 * 1000 / 0.5)


@pytest.mark.parametrize(
    ("bounds", "cell_size"),
    [
        (box(-1, -1, 1, 1), 1.0),
        (box(-32.4, -12.6, 32.4, 12.6), 1.0),
        (box(0, 0, 100.2, 3), 10.0),
        (box(-3000, 500, 9000, 600), 1000.0),
    ],
)
def test_the_grid_covers_the_world_with_whole_cells(bounds, cell_size):
    grid = grid_around(bounds)

    half = grid.cells * grid.cell_size / 2
    assert grid.cell_size == cell_size
    assert grid.cells <= 200
    assert box(grid.x - half, grid.y - half, grid.x + half, grid.y + half).contains(bounds)
    assert (grid.x - half) % grid.cell_size == 0
    assert (grid.y - half) % grid.cell_size == 0

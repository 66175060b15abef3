"""The extent of a world, and the view of it."""

from io import BytesIO

import pytest
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from flatland_viz.bounds import Bounds, around, bounds_of_markers, framed, grid_around


def serialized(*markers: Marker) -> bytes:
    """A serialized message."""
    buffer = BytesIO()
    MarkerArray(markers=list(markers)).serialize(buffer)
    return buffer.getvalue()


def lines(*points, **fields) -> Marker:
    """A marker with these points and a frame."""
    marker = Marker(type=Marker.LINE_LIST, points=[Point(*point) for point in points], **fields)
    marker.header.frame_id = "map"
    return marker


def test_the_bounding_box_of_walls():
    marker = lines((1.0, 2.0, 9.0), (-3.5, 4.0, 0.0), (0.0, -0.25, -7.0))

    assert bounds_of_markers(serialized(marker)) == Bounds(-3.5, -0.25, 1.0, 4.0)


def test_several_markers_with_strings_and_colours_are_read():
    data = serialized(
        lines((0, 0, 0), (1, 1, 0), ns="walls", colors=[ColorRGBA(1, 0, 0, 1)] * 2, text="a b"),
        lines(ns="no points"),
        lines((5, -6, 0), ns="é", mesh_resource="package://x/y.dae"),
    )

    assert bounds_of_markers(data) == Bounds(0, -6, 5, 1)


@pytest.mark.parametrize("markers", [[], [lines()], [lines(), Marker(action=Marker.DELETEALL)]])
def test_without_points_there_is_no_box(markers):
    assert bounds_of_markers(serialized(*markers)) is None


def test_the_bounding_box_of_boxes():
    assert around([Bounds(0, 0, 1, 1), None, Bounds(-2, 0.5, 0, 3)]) == Bounds(-2, 0, 1, 3)


def test_a_world_without_walls_is_ten_metres_wide():
    assert around([]) == around([None]) == Bounds(-5, -5, 5, 5)


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
def test_a_point_is_not_magnified_without_end(bounds):
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
def test_the_grid_reaches_beyond_the_world_with_lines_at_whole_cells(bounds, cell_size):
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

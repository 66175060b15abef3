"""The walls of a layer as markers, serialized by us and deserialized by ROS's own code."""

from pathlib import Path

import numpy as np
import pytest
from visualization_msgs.msg import Marker, MarkerArray

from flatland_server.messages.serialized_markers import LazyMarkerArray, array_of
from flatland_server.messages.wall_markers import flat_walls, upright_walls
from flatland_server.messages.wire_form import serialized
from flatland_server.models.layer import LayerConfig

COLOR = (0.25, 0.5, 0.75, 1.0)
SEGMENTS = np.array([[0.0, 0.0, 4.0, 0.0], [4.0, 0.0, 4.0, 3.0]])


def config(min_z=0.0, max_z=1.0):
    return LayerConfig(("room", "hall"), 3, COLOR, min_z, max_z, Path("map.yaml"))


def received(message):
    return MarkerArray().deserialize(serialized(message)).markers


def corners(marker):
    return [(p.x, p.y, p.z) for p in marker.points]


def test_flat_walls_are_lines_on_the_ground():
    [marker] = received(array_of([flat_walls(config(0.5, 2.0), SEGMENTS)]))

    assert (marker.type, marker.ns, marker.header.frame_id) == (Marker.LINE_LIST, "room", "map")
    assert (marker.color.r, marker.color.g, marker.color.b, marker.color.a) == COLOR
    assert marker.pose.orientation.w == 1.0
    assert corners(marker) == [(0, 0, 0), (4, 0, 0), (4, 0, 0), (4, 3, 0)]


def test_upright_walls_fill_the_height_above_each_segment():
    [marker] = received(array_of([upright_walls(config(0.5, 2.0), SEGMENTS)]))

    assert (marker.type, marker.ns, marker.header.frame_id) == (Marker.TRIANGLE_LIST, "room", "map")
    triangles = np.reshape(corners(marker), (-1, 3, 3))
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    assert areas == pytest.approx([3.0, 3.0, 2.25, 2.25])  # halves of 4 x 1.5 and 3 x 1.5
    for (x1, y1, x2, y2), pair in zip(SEGMENTS, triangles.reshape(-1, 6, 3)):
        expected = {(x, y, z) for x, y in ((x1, y1), (x2, y2)) for z in (0.5, 2.0)}
        assert set(map(tuple, pair)) == expected


@pytest.mark.parametrize("max_z", [0.5, 0.2])
def test_walls_without_a_height_are_lines_at_min_z(max_z):
    [marker] = received(array_of([upright_walls(config(0.5, max_z), SEGMENTS)]))

    assert marker.type == Marker.LINE_LIST
    assert {z for _, _, z in corners(marker)} == {0.5}


@pytest.mark.parametrize("walls", [flat_walls, upright_walls])
def test_no_walls_are_no_marker(walls):
    """Rviz reports a marker without points as an error."""
    assert received(array_of([walls(config(), np.empty((0, 4)))])) == []


def test_a_lazy_array_is_made_when_it_is_sent():
    calls = []

    def make():
        calls.append(1)
        return array_of([flat_walls(config(), SEGMENTS)])

    message = LazyMarkerArray(make)

    assert calls == []
    assert [marker.ns for marker in received(message)] == ["room"]
    assert calls == [1]

"""The walls of layers: markers for rviz, and flatland_msgs/Walls for the window.

They are serialized from arrays of perhaps a million points.
"""

from typing import Any, Callable, List, Tuple

import numpy as np

from flatland_server.arrays import FloatArray, Segments
from flatland_server.messages.conversions import FRAME_ID
from flatland_server.messages.message_types import get
from flatland_server.messages.serialized_markers import MarkerBytes, serialized
from flatland_server.messages.wire_form import LENGTH
from flatland_server.models.layer import LayerConfig

ColorRGBA = get("std_msgs/ColorRGBA")
Header = get("std_msgs/Header")
LayerWalls = get("flatland_msgs/LayerWalls")
Marker = get("visualization_msgs/Marker")
Point = get("geometry_msgs/Point")
Walls = get("flatland_msgs/Walls")

_WALL_WIDTH = 0.05  # m
_NONE = MarkerBytes(0, b"")


def flat_walls(config: LayerConfig, segments: Segments) -> MarkerBytes:
    """The walls as lines on the ground; no marker if there are none.

    Args:
        config: their layer's config.
        segments: shape (n, 4), x1, y1, x2, y2 [m].
    """
    return _lines(config, segments, 0.0)


def upright_walls(config: LayerConfig, segments: Segments) -> MarkerBytes:
    """The walls as rectangles between `min_z` and `max_z`; no marker if there are none.

    If `max_z` is not above `min_z`, they are lines at `min_z`. The arguments are those of
    `flat_walls`.
    """
    low, high = config.min_z, config.max_z
    if high <= low:
        return _lines(config, segments, low)
    begin, end = segments[:, :2], segments[:, 2:]
    triangles = (
        *((begin, low), (end, low), (end, high)),
        *((begin, low), (end, high), (begin, high)),
    )
    points = np.stack([_at_height(corner, z) for corner, z in triangles], axis=1)
    marker = _marker(config, Marker.TRIANGLE_LIST)
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    return _with_points(marker, points.reshape(-1, 3))


def _lines(config: LayerConfig, segments: Segments, z: float) -> MarkerBytes:
    marker = _marker(config, Marker.LINE_LIST)
    marker.scale.x = _WALL_WIDTH
    return _with_points(marker, _at_height(segments.reshape(-1, 2), z))


def _marker(config: LayerConfig, type: int) -> Any:
    marker = Marker(ns=config.names[0], type=type, action=Marker.ADD)
    marker.header.frame_id = FRAME_ID
    marker.color = ColorRGBA(*config.color)
    marker.pose.orientation.w = 1.0
    return marker


def _at_height(points: FloatArray, z: float) -> FloatArray:
    """Points of shape (n, 2) at a height: shape (n, 3)."""
    return np.column_stack([points, np.full(len(points), z)])


def _with_points(marker: Any, points: FloatArray) -> MarkerBytes:
    """A serialized marker with these points, shape (n, 3); none if there are no points."""
    if len(points) == 0:
        return _NONE
    # The offset of the point list's length: the first byte in which a marker without points differs
    # from one with a point.
    empty = serialized([marker]).data
    marker.points = [Point()]
    one_point = serialized([marker]).data
    begin = next(i for i, (a, b) in enumerate(zip(empty, one_point)) if a != b)
    length = LENGTH.pack(len(points))
    data = np.ascontiguousarray(points, "<f8").data.cast("B")
    return MarkerBytes(1, b"".join([empty[:begin], length, data, empty[begin + 4 :]]))


class LazyWalls(Walls):  # type: ignore[misc, valid-type]
    """A Walls message that is serialized when it is sent, hence never without subscribers.

    Args:
        write: writes the serialized message into a buffer. rospy calls it on a thread of its own
            when a subscriber connects to a latched topic, so it must not read what the simulation
            changes.
    """

    __slots__ = ["_write"]

    def __init__(self, write: Callable[[Any], None]) -> None:
        super().__init__()
        self._write = write

    def serialize(self, buff: Any) -> None:
        """Writes the message into a buffer; called by rospy."""
        self._write(buff)


def walls_of(layers: List[Tuple[LayerConfig, Segments]]) -> LazyWalls:
    """The walls of layers, to be serialized later.

    Args:
        layers: their entries, and segments of shape (n, 4), x1, y1, x2, y2 [m].
    """

    def write(buff: Any) -> None:
        Header(frame_id=FRAME_ID).serialize(buff)
        buff.write(LENGTH.pack(len(layers)))
        for config, segments in layers:
            # Without segments, their number is the last field.
            LayerWalls(
                name=config.names[0], color=ColorRGBA(*config.color), encloses=config.encloses
            ).serialize(buff)
            buff.seek(-LENGTH.size, 1)
            buff.write(LENGTH.pack(segments.size))
            buff.write(segments.astype("<f4").data.cast("B"))

    return LazyWalls(write)

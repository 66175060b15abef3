"""The walls of a layer as one marker, serialized from an array of perhaps a million points."""

import struct

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from flatland_server.arrays import FloatArray
from flatland_server.messages.serialized_markers import (
    MarkerBytes,
    SerializedMarkerArray,
    array_of,
    serialized,
)
from flatland_server.models.layer import Layer

_WALL_WIDTH = 0.05  # m


def wall_markers(layer: Layer, frame_id: str) -> SerializedMarkerArray:
    """All walls of a layer as one line list."""
    marker = Marker(ns=layer.name, type=Marker.LINE_LIST, action=Marker.ADD)
    marker.header.frame_id = frame_id
    marker.scale.x = _WALL_WIDTH
    marker.color = ColorRGBA(*layer.config.color)
    marker.pose.orientation.w = 1.0
    points = _lines(layer).astype("<f8")
    # The offset of the point list's length: the first byte in which a marker without points differs
    # from one with a point.
    empty = serialized([marker]).data
    marker.points = [Point()]
    one_point = serialized([marker]).data
    begin = next(i for i, (a, b) in enumerate(zip(empty, one_point)) if a != b)
    length = struct.pack("<I", len(points))
    full = empty[:begin] + length + points.tobytes() + empty[begin + 4 :]
    return array_of([MarkerBytes(1, full)])


def _lines(layer: Layer) -> FloatArray:
    """Pairs of points, shape (n, 3): walls at min_z; if max_z is above that, also at max_z, and
    the vertical edges between both.
    """
    corners = layer.segments.reshape(-1, 2)
    low, high = (
        np.column_stack([corners, np.full(len(corners), z)])
        for z in (layer.config.min_z, layer.config.max_z)
    )
    if layer.config.max_z <= layer.config.min_z:
        return low
    upright = np.stack([low, high], axis=1).reshape(-1, 3)
    return np.concatenate([low, high, upright])

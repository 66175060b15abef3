"""The shapes of a body as rviz markers: filled triangles, and an outline that shows the heading."""

from typing import List, Sequence, Tuple

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from flatland_server.footprint import Circle
from flatland_server.model_body import BodyConfig

_OUTLINE_WIDTH = 0.01  # m
_FILL_Z = 0.01  # above the map image that a navigation stack shows at z = 0
_OUTLINE_Z = 0.02

Corners = Sequence[Tuple[float, float]]


def body_markers(config: BodyConfig, namespace: str) -> List[Marker]:
    """Markers in the body's own frame; whoever publishes them sets frame and pose."""
    fill = _marker(namespace, 0, Marker.TRIANGLE_LIST, config.color)
    fill.scale.x = fill.scale.y = fill.scale.z = 1.0
    red, green, blue, alpha = config.color
    dark = (0.4 * red, 0.4 * green, 0.4 * blue, max(alpha, 0.8))
    outline = _marker(namespace, 1, Marker.LINE_LIST, dark)
    outline.scale.x = _OUTLINE_WIDTH
    for footprint in config.footprints:
        corners = footprint.shape.outline()
        for i in range(1, len(corners) - 1):
            fill.points += _points((corners[0], corners[i], corners[i + 1]), _FILL_Z)
        for i, corner in enumerate(corners):
            outline.points += _points((corner, corners[i - 1]), _OUTLINE_Z)
        if isinstance(footprint.shape, Circle):
            x, y = footprint.shape.center
            outline.points += _points(((x, y), (x + footprint.shape.radius, y)), _OUTLINE_Z)
    return [marker for marker in (fill, outline) if marker.points]


def _marker(namespace: str, id: int, type: int, color: Sequence[float]) -> Marker:
    marker = Marker(ns=namespace, id=id, type=type, action=Marker.ADD, color=ColorRGBA(*color))
    marker.pose.orientation.w = 1.0
    return marker


def _points(corners: Corners, z: float) -> List[Point]:
    return [Point(x, y, z) for x, y in corners]

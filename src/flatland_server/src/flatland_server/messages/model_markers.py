"""The rviz markers of a model: its footprints, filled and outlined, and its joints."""

from typing import Any, List, Sequence, Tuple

from flatland_server.geometry import Pose
from flatland_server.messages.conversions import FRAME_ID, fill_pose
from flatland_server.messages.message_types import get
from flatland_server.messages.serialized_markers import MarkerBytes, MovingMarkers
from flatland_server.models.footprint import Circle
from flatland_server.models.joint import JointConfig
from flatland_server.models.model import Model, ModelConfig
from flatland_server.models.model_body import BodyConfig

Marker = get("visualization_msgs/Marker")
Point = get("geometry_msgs/Point")
ColorRGBA = get("std_msgs/ColorRGBA")

_OUTLINE_WIDTH = 0.01  # m
_JOINT_WIDTH = 0.02  # m
_FILL_Z = 0.01  # above the map image that a navigation stack shows at z = 0
_OUTLINE_Z = 0.02
_JOINT_Z = 0.03

Corners = Sequence[Tuple[float, float]]


class ModelMarkers:
    """The markers of a model in the world."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._make()

    def _make(self) -> None:
        model = self._model
        self._footprint_revision = model.footprint_revision
        placed = _markers_of(model.config, f"{model.name}/")
        markers = [marker for marker, _ in placed]
        bodies = [model.bodies[name] for _, name in placed]
        for marker in markers:
            marker.header.frame_id = FRAME_ID
        self._markers = MovingMarkers(markers)
        self._unique = list(dict.fromkeys(bodies))
        self._index = [self._unique.index(body) for body in bodies]
        self._poses: List[Tuple[float, float, float]] = []

    def place(self) -> bool:
        """Brings the markers up to date with the model. Returns whether any has changed."""
        if self._footprint_revision != self._model.footprint_revision:
            self._make()
        poses = [body.physics_body.pose for body in self._unique]
        has_moved = poses != self._poses
        self._poses = poses
        return has_moved

    def bytes(self) -> MarkerBytes:
        """The serialized markers, at the poses set by `place`."""
        return self._markers.place(Pose(*self._poses[index]) for index in self._index)


def preview(config: ModelConfig) -> List[Any]:
    """The markers of a model that is not in a world: in its own frame, with an empty frame_id."""
    poses = {body.name: body.pose for body in config.bodies}
    placed = _markers_of(config, "")
    for marker, body in placed:
        fill_pose(marker.pose, poses[body])
    return [marker for marker, _ in placed]


def _markers_of(config: ModelConfig, prefix: str) -> List[Tuple[Any, str]]:
    """All markers of a model, each with the name of the body that has its frame.

    Args:
        config: the model.
        prefix: put before each marker's namespace.
    """
    markers = [
        (marker, body.name)
        for body in config.bodies
        for marker in body_markers(body, prefix + body.name)
    ]
    # In the frame of the joint's first body, in which the anchor is fixed.
    markers += [
        (joint_marker(joint, prefix + joint.name), joint.bodies[0]) for joint in config.joints
    ]
    return markers


def body_markers(config: BodyConfig, namespace: str) -> List[Any]:
    """Markers in the body's own frame: footprints filled and outlined, sensors outlined only."""
    fill = _marker(namespace, 0, Marker.TRIANGLE_LIST, config.color)
    fill.scale.x = fill.scale.y = fill.scale.z = 1.0
    red, green, blue, alpha = config.color
    dark = (0.4 * red, 0.4 * green, 0.4 * blue, max(alpha, 0.8))
    outline = _marker(namespace, 1, Marker.LINE_LIST, dark)
    outline.scale.x = _OUTLINE_WIDTH
    for footprint in config.footprints:
        corners = footprint.shape.outline()
        if not footprint.sensor:
            for i in range(1, len(corners) - 1):
                fill.points += _points((corners[0], corners[i], corners[i + 1]), _FILL_Z)
        for i, corner in enumerate(corners):
            outline.points += _points((corner, corners[i - 1]), _OUTLINE_Z)
        if isinstance(footprint.shape, Circle):
            x, y = footprint.shape.center
            outline.points += _points(((x, y), (x + footprint.shape.radius, y)), _OUTLINE_Z)
    return [marker for marker in (fill, outline) if marker.points]


def joint_marker(config: JointConfig, namespace: str) -> Any:
    """A cross at a joint's anchor, in the frame of its first body."""
    marker = _marker(namespace, 0, Marker.LINE_LIST, config.color)
    marker.scale.x = _JOINT_WIDTH
    x, y = config.anchors[0]
    arm = 2.5 * _JOINT_WIDTH
    marker.points = _points(((x - arm, y), (x + arm, y), (x, y - arm), (x, y + arm)), _JOINT_Z)
    return marker


def _marker(namespace: str, id: int, type: int, color: Sequence[float]) -> Any:
    marker = Marker(ns=namespace, id=id, type=type, action=Marker.ADD, color=ColorRGBA(*color))
    marker.pose.orientation.w = 1.0
    return marker


def _points(corners: Corners, z: float) -> List[Any]:
    return [Point(x, y, z) for x, y in corners]

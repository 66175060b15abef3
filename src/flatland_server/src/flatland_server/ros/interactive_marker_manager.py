"""Interactive markers: models that are dragged, turned and deleted by mouse, in rviz."""

import math
import time
from typing import Dict, List, NamedTuple, Optional, Tuple

import rospy
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerControl,
    InteractiveMarkerFeedback,
    Marker,
    MenuEntry,
)

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.hub.client_edits import Edit
from flatland_server.hub.hub import Hub
from flatland_server.hub.map_to_odom import FRAME_ID
from flatland_server.messages import fill_pose, yaw_of
from flatland_server.messages.model_markers import preview
from flatland_server.models.model import Model
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.ros.ros_transport import RosTransport

_DELETE = 1
_HANDLE_Z = 0.05
"""The height of handles [m]: above the outlines of models, since the mouse picks the topmost."""

_DRAG_TIMEOUT = 3.0
"""Real seconds without feedback after which a drag ends: rviz sends it every 0.25 s."""

_WARNING_PERIOD = 3.0  # s of ROS time, per drag that leaves the world

_KEEP_ALIVE_PERIOD = rospy.Duration(0.5)
"""In ROS time, simulated or not, which rviz uses to time out servers."""

_REAL_KEEP_ALIVE_PERIOD = 1.0
"""The same in real seconds, for pauses: a new subscriber shows nothing before the first message."""


class _Handle(NamedTuple):
    """The shown state of a model."""

    model: Model
    footprint_revision: int
    centre: Pose
    """The middle of its footprints, in the model's frame."""
    pose: Tuple[float, float, float]
    """The pose of its base, at the last update."""


class _Drag:
    """A model that is being dragged: real time of the last feedback [s], and the edit so far."""

    def __init__(self) -> None:
        self.updated = 0.0
        self.edit: Optional[Edit] = None


class InteractiveMarkerManager:
    """Offers an interactive marker for each model at `interactive_model_markers`.

    While a model is dragged, the simulation is held.

    Args:
        hub: has the models, and is told of changes.
        transport: hands feedback over to the simulation's thread.
        rate: how often markers follow their models [Hz of real time], while there are subscribers.
    """

    def __init__(self, hub: Hub, transport: RosTransport, rate: float) -> None:
        self._edits = hub.edits
        self._manager = hub.manager
        self._world = hub.world
        self._transport = transport
        self._timer = RealTimeTimer(1.0 / rate)
        self._server = transport.rospy_calls.marker_server("interactive_model_markers")
        self._keep_alive_due = rospy.Time()
        self._keep_alive_timer = RealTimeTimer(_REAL_KEEP_ALIVE_PERIOD)
        self._shown: Dict[str, _Handle] = {}
        self._drags: Dict[str, _Drag] = {}  # by model

    def update(self) -> None:
        """Updates the markers if it is time to; to be called often."""
        self._keep_alive()
        if not self._timer.check_update():
            return
        oldest = time.monotonic() - _DRAG_TIMEOUT
        for name in [name for name, drag in self._drags.items() if drag.updated < oldest]:
            self._end_drag(name)
        gone, new = self._follow_models()
        has_moved = self._server.update_pub.get_num_connections() > 0 and self._follow_poses()
        if gone or new or has_moved:
            self._server.applyChanges()
            for name in new:
                self._server.allow_drag(name)

    def _keep_alive(self) -> None:
        now = rospy.get_rostime()
        has_jumped_back = now + _KEEP_ALIVE_PERIOD < self._keep_alive_due
        is_due = now >= self._keep_alive_due or has_jumped_back
        is_due |= not self._manager.is_stepping and self._keep_alive_timer.check_update()
        if is_due and self._server.update_pub.get_num_connections() > 0:
            self._keep_alive_due = now + _KEEP_ALIVE_PERIOD
            self._server.keep_alive()

    def _follow_models(self) -> Tuple[List[str], List[str]]:
        """Adds and removes markers. Returns the names of those that are gone, and new."""
        models = self._world.models
        gone = [name for name, shown in self._shown.items() if models.get(name) is not shown.model]
        for name in gone:
            del self._shown[name]
            self._server.erase(name)
            if name in self._drags:
                self._end_drag(name)
        new = [name for name in models if name not in self._shown or self._is_outdated(name)]
        for name in new:
            model = models[name]
            centre, radius = _circle_around(model)
            pose = model.base.physics_body.pose
            self._shown[name] = _Handle(model, model.footprint_revision, centre, pose)
            self._server.insert(
                _interactive_marker(model, centre, radius),
                lambda feedback: self._transport.post(lambda: self._on_feedback(feedback)),
            )
        return gone, new

    def _is_outdated(self, name: str) -> bool:
        """True for a marker of former footprints, unless it is being dragged."""
        model, revision, *_ = self._shown[name]
        return revision != model.footprint_revision and name not in self._drags

    def _follow_poses(self) -> bool:
        """Moves the markers of models that have moved; returns whether there are any.

        Models that are being dragged are left out: rviz would apply a pose received during a drag
        at its end, so that the model would jump back from the place where the mouse has left it.
        """
        has_moved = False
        for name, shown in self._shown.items():
            pose = shown.model.base.physics_body.pose
            if pose != shown.pose and name not in self._drags:
                self._shown[name] = shown._replace(pose=pose)
                place = shown.model.pose.compose(shown.centre)
                has_moved |= self._server.setPose(name, _pose_message(place))
        return has_moved

    def _on_feedback(self, feedback: InteractiveMarkerFeedback) -> None:
        name, event = feedback.marker_name, feedback.event_type
        if name not in self._world.models:
            return
        if event == InteractiveMarkerFeedback.MENU_SELECT:
            if feedback.menu_entry_id == _DELETE:
                self._edits.delete([name])
            return
        if event == InteractiveMarkerFeedback.MOUSE_DOWN:
            self._begin_drag(name)
        elif event == InteractiveMarkerFeedback.MOUSE_UP:
            self._begin_drag(name)
            self._move(name, feedback)
            self._end_drag(name)
        elif event == InteractiveMarkerFeedback.POSE_UPDATE:
            self._begin_drag(name)
            self._move(name, feedback)
        elif name in self._drags:
            self._drags[name].updated = time.monotonic()

    def _move(self, name: str, feedback: InteractiveMarkerFeedback) -> None:
        centre = self._shown[name].centre if name in self._shown else Pose(0.0, 0.0, 0.0)
        position, yaw = feedback.pose.position, yaw_of(feedback.pose.orientation)
        pose = Pose(position.x, position.y, yaw).compose(centre.inverse())
        try:
            drag = self._drags[name]
            drag.edit = self._edits.move(name, pose, drag.edit)
        except FlatlandError as error:  # outside the limits of the world: the model stays
            rospy.logwarn_throttle(_WARNING_PERIOD, f'"{name}" is not moved: {error}')

    def _begin_drag(self, name: str) -> None:
        self._manager.is_held = True
        self._drags.setdefault(name, _Drag()).updated = time.monotonic()

    def _end_drag(self, name: str) -> None:
        if self._drags.pop(name, None) is None:
            return
        self._server.allow_drag(name)
        self._manager.is_held = bool(self._drags)


def _pose_message(pose: Pose) -> object:
    message = InteractiveMarker().pose
    fill_pose(message, pose)
    return message


def _circle_around(model: Model) -> Tuple[Pose, float]:
    """A circle around a model as it is now: its centre, in the model's frame, and its radius [m].

    The centre is that of the bounding box of the model's footprints, without sensors if there are
    other footprints.
    """
    to_model = model.pose.inverse()
    solid: List[Tuple[float, float]] = []
    sensors: List[Tuple[float, float]] = []
    for body in model.bodies.values():
        for footprint in body.config.footprints:
            for corner in footprint.shape.outline():
                point = to_model.apply(*body.physics_body.world_point(corner))
                (sensors if footprint.sensor else solid).append(point)
    points = solid or sensors or [(0.0, 0.0)]
    xs, ys = zip(*points)
    # To the millimetre: a symmetric model has its centre exactly at its origin.
    x, y = round((min(xs) + max(xs)) / 2, 3), round((min(ys) + max(ys)) / 2, 3)
    return Pose(x, y, 0.0), max(math.dist((x, y), point) for point in points)


def _interactive_marker(model: Model, centre: Pose, radius: float) -> InteractiveMarker:
    """The marker of a model: its footprints to drag it, and a ring to turn it.

    Args:
        model: the model.
        centre: of the ring, in the model's frame.
        radius: of a circle around the model [m].
    """
    marker = InteractiveMarker(name=model.name, pose=_pose_message(model.pose.compose(centre)))
    marker.header.frame_id = FRAME_ID  # no stamp: feedback comes in this frame
    marker.menu_entries = [MenuEntry(id=_DELETE, title=f"Delete {model.name}")]
    shapes = [shape for shape in preview(model.config) if shape.type == Marker.TRIANGLE_LIST]
    for shape in shapes:
        shape.color.a = 0.01  # for the mouse only; other markers show the model
        shape.pose.position.x -= centre.x
        shape.pose.position.y -= centre.y
        shape.pose.position.z = _HANDLE_Z
    marker.scale = 2.5 * max(0.2, radius)
    drag = InteractiveMarkerControl(
        name="drag",
        interaction_mode=InteractiveMarkerControl.MOVE_PLANE,
        always_visible=True,
        markers=shapes or [_disc(marker.scale / 2.5)],
    )
    turn = InteractiveMarkerControl(
        name="turn", interaction_mode=InteractiveMarkerControl.ROTATE_AXIS
    )
    for control in (drag, turn):  # their axis, x, points up
        control.orientation.w = control.orientation.y = math.sqrt(0.5)
    marker.controls = [drag, turn]
    return marker


def _disc(radius: float) -> Marker:
    marker = Marker(type=Marker.CYLINDER)
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = 2.0 * radius
    marker.scale.z = 0.01
    marker.color.a = 0.01
    return marker

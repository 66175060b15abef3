"""Interactive markers: models that are dragged, turned and deleted by mouse, in rviz.

rviz's display reads two topics. `update` has the changes, each with a number; `update_full` is
latched, and has all markers as of a number, from which a new display follows the changes. Without
any message for a second, a display takes the server to be gone.
"""

import logging
import math
import time
from copy import copy
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.hub.client_edits import Edit
from flatland_server.hub.hub import Hub
from flatland_server.messages.conversions import FRAME_ID, fill_pose, yaw_of
from flatland_server.messages.message_types import get
from flatland_server.messages.model_markers import preview
from flatland_server.models.model import Model
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.transport.transport import Transport

Feedback = get("visualization_msgs/InteractiveMarkerFeedback")
Init = get("visualization_msgs/InteractiveMarkerInit")
InteractiveMarker = get("visualization_msgs/InteractiveMarker")
InteractiveMarkerControl = get("visualization_msgs/InteractiveMarkerControl")
MarkerPose = get("visualization_msgs/InteractiveMarkerPose")
Update = get("visualization_msgs/InteractiveMarkerUpdate")
Marker = get("visualization_msgs/Marker")
MenuEntry = get("visualization_msgs/MenuEntry")

logger = logging.getLogger(__name__)

_DELETE = 1
_ORIGIN = "origin"
"""The control of feedback with the pose of a model's origin, as the window sends it. rviz sends the
pose of the marker, which is at the centre of the footprints."""
_HANDLE_Z = 0.05
"""The height of handles [m]: above the outlines of models, since the mouse picks the topmost."""

_DRAG_TIMEOUT = 3.0
"""Real seconds without feedback after which a drag ends: rviz sends it every 0.25 s."""

_KEEP_ALIVE_PERIOD = 0.5
"""Seconds of simulated time, or of real time if that is less: rviz goes by either."""


class _Handle(NamedTuple):
    """The shown state of a model."""

    model: Model
    footprint_revision: int
    centre: Pose
    """The middle of its footprints, in the model's frame."""
    pose: Tuple[float, float, float]
    """The pose of its base, at the last update."""


class _Drag:
    """A model that is being dragged.

    Attributes:
        client: drags it; others do not meanwhile.
        updated: real time of the last feedback [s].
        edit: all of the drag so far.
        has_failed: whether the model was to leave the world.
    """

    def __init__(self, client: str) -> None:
        self.client = client
        self.updated = 0.0
        self.edit: Optional[Edit] = None
        self.has_failed = False


class InteractiveMarkerManager:
    """Offers an interactive marker for each model at `interactive_model_markers`.

    While a model is dragged, the simulation is held.

    Args:
        hub: hub with the models; it records their changes.
        rate: how often markers follow their models [Hz of real time], while there are subscribers.
    """

    def __init__(self, hub: Hub, rate: float) -> None:
        self._edits = hub.edits
        self._manager = hub.manager
        self._world = hub.world
        self._timer = RealTimeTimer(1.0 / rate)
        self._server = _MarkerServer(hub.transport, "interactive_model_markers", self._on_feedback)
        self._alive = (0.0, 0.0)  # simulated and real time of the last message
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
        has_moved = self._server.has_subscribers and self._follow_poses()
        if gone or new or has_moved:
            self._server.send()

    def _keep_alive(self) -> None:
        now = self._manager.timekeeper.seconds, time.monotonic()
        passed = max(abs(time - before) for time, before in zip(now, self._alive))
        if passed >= _KEEP_ALIVE_PERIOD and self._server.has_subscribers:
            self._alive = now
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
            self._server.insert(_interactive_marker(model, centre, radius))
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
                self._server.move(name, _pose_message(place))
                has_moved = True
        return has_moved

    def _on_feedback(self, feedback: Any) -> None:
        name, event = feedback.marker_name, feedback.event_type
        shown, drag = self._shown.get(name), self._drags.get(name)
        if shown is None or self._world.models.get(name) is not shown.model:
            return
        if drag is not None and drag.client != feedback.client_id:
            return
        if event == Feedback.MENU_SELECT:
            if feedback.menu_entry_id == _DELETE:
                self._edits.delete([name])
            return
        if event in (Feedback.MOUSE_DOWN, Feedback.POSE_UPDATE, Feedback.MOUSE_UP):
            self._manager.is_held = True
            drag = self._drags.setdefault(name, _Drag(feedback.client_id))
            if event != Feedback.MOUSE_DOWN:
                self._move(name, feedback, drag)
            if event == Feedback.MOUSE_UP:
                self._end_drag(name)
        if drag is not None:
            drag.updated = time.monotonic()

    def _move(self, name: str, feedback: Any, drag: _Drag) -> None:
        position, yaw = feedback.pose.position, yaw_of(feedback.pose.orientation)
        pose = Pose(position.x, position.y, yaw)
        if feedback.control_name != _ORIGIN:
            pose = pose.compose(self._shown[name].centre.inverse())
        try:
            drag.edit = self._edits.move(name, pose, drag.edit)
        except FlatlandError as error:  # outside the limits of the world: the model stays
            if not drag.has_failed:
                drag.has_failed = True
                logger.warning('"%s" is not moved: %s', name, error)

    def _end_drag(self, name: str) -> None:
        if self._drags.pop(name, None) is None:
            return
        self._manager.is_held = bool(self._drags)


class _MarkerServer:
    """The topics of interactive markers.

    Args:
        transport: transport on which the topics are published.
        name: prefix of the topics' names, before `/update` and the others.
        on_feedback: called with each message of a display, between two steps.
    """

    def __init__(self, transport: Transport, name: str, on_feedback: Callable[[Any], None]) -> None:
        self._id = transport.node_name
        self._markers: Dict[str, Any] = {}
        self._changed: Dict[str, Any] = {}  # markers to send whole
        self._moved: Dict[str, Any] = {}
        self._erased: List[str] = []
        self._number = 0
        advertise = transport.advertise
        self._full = advertise(f"{name}/update_full", Init, latch=True, queue_size=100)
        self._updates = advertise(f"{name}/update", Update, latch=False, queue_size=100)
        transport.subscribe(f"{name}/feedback", Feedback, on_feedback)
        self._publish_all()

    @property
    def has_subscribers(self) -> bool:
        """True if there is a display."""
        return self._updates.has_subscribers

    def insert(self, marker: Any) -> None:
        """Adds a marker, in place of one of the same name; `send` sends it.

        Args:
            marker: a visualization_msgs/InteractiveMarker.
        """
        self._markers[marker.name] = self._changed[marker.name] = marker

    def erase(self, name: str) -> None:
        """Removes a marker."""
        for markers in (self._markers, self._changed, self._moved):
            markers.pop(name, None)
        self._erased.append(name)

    def move(self, name: str, pose: Any) -> None:
        """Moves a marker.

        Args:
            name: the marker's name.
            pose: a geometry_msgs/Pose.
        """
        marker = self._markers[name] = copy(self._markers[name])  # that of messages stays
        marker.pose = pose
        self._moved[name] = MarkerPose(marker.header, pose, name)

    def send(self) -> None:
        """Sends all changes."""
        self._number += 1
        # A display inserts first: it would erase a marker that replaces one of its name.
        erased = [name for name in self._erased if name not in self._markers]
        self._publish(Update.UPDATE, [*self._changed.values()], [*self._moved.values()], erased)
        self._changed.clear()
        self._moved.clear()
        self._erased.clear()
        self._publish_all()

    def keep_alive(self) -> None:
        """Tells displays that the markers are still there."""
        self._publish(Update.KEEP_ALIVE, [], [], [])

    def _publish(self, kind: int, *changes: List[Any]) -> None:
        self._updates.publish(Update(self._id, self._number, kind, *changes))

    def _publish_all(self) -> None:
        self._full.publish(Init(self._id, self._number, list(self._markers.values())))


def _pose_message(pose: Pose) -> Any:
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


def _interactive_marker(model: Model, centre: Pose, radius: float) -> Any:
    """The marker of a model: its footprints to drag it, and a ring to turn it.

    Args:
        model: model of which the marker shows the footprints.
        centre: centre of the ring, in the model's frame [m, m, rad].
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


def _disc(radius: float) -> Any:
    marker = Marker(type=Marker.CYLINDER)
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = 2.0 * radius
    marker.scale.z = 0.01
    marker.color.a = 0.01
    return marker

"""The switch "Trail": lines of the selected robot's way and of its odometry, in the map."""

import math
import threading
from typing import Any, Dict, List, Optional

import rospy
from flatland_msgs.msg import ModelStates
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from python_qt_binding.QtCore import QObject, QTimer
from python_qt_binding.QtWidgets import QAction, QMenu
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from flatland_viz.model_list import Model
from flatland_viz.scene import Scene
from flatland_viz.selection import Selection
from flatland_viz.trail import Trail, Trails

_FRAME = "map"
_PERIOD = 200  # ms
_WIDTH = 0.05  # m
_TRUTH = ColorRGBA(0.0, 0.45, 0.7, 1.0)
_BELIEF = ColorRGBA(0.9, 0.62, 0.0, 1.0)


class TrailDisplay(QObject):
    """Subscribes to models and odometry while it is switched on, and to nothing otherwise.

    Args:
        menu: menu that gets the switch, before its first separator.
        scene: scene to draw the lines in.
        selection: selected robot.
        states: the topic of the server's flatland_msgs/ModelStates.
    """

    def __init__(self, menu: QMenu, scene: Scene, selection: Selection, states: str) -> None:
        super().__init__(menu)
        self._scene = scene
        self._selection = selection
        self._states = states
        self._models: Dict[str, Model] = {}
        self._lock = threading.Lock()  # rospy calls back on threads of its own
        self._trails = Trails()
        self._followed = ("", "")  # a model, and the topic of its odometry
        self._odometry: Optional[rospy.Subscriber] = None
        self._subscriber: Optional[rospy.Subscriber] = None
        self._publisher: Optional[rospy.Publisher] = None
        self._published: Any = None
        self.action = QAction("T&rail", self, objectName="action_show_trail")
        self.action.setCheckable(True)
        self.action.setShortcut("T")
        self.action.setToolTip("The selected robot's way (blue), and its odometry's (orange)")
        self.action.toggled.connect(self._switch)
        menu.insertAction(next(each for each in menu.actions() if each.isSeparator()), self.action)
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._update)
        selection.changed.connect(lambda name: self._follow())

    def set_models(self, models: Dict[str, Model]) -> None:
        """Sets the models in the world."""
        self._models = models
        self._follow()

    def _switch(self, is_on: bool) -> None:
        if is_on:
            self._trails = Trails()
            topic = rospy.resolve_name("~trail")
            self._publisher = rospy.Publisher(topic, Marker, queue_size=4, latch=True)
            self._scene.show_markers("trail", topic)
            self._subscriber = rospy.Subscriber(self._states, ModelStates, self._see)
            self._timer.start(_PERIOD)
        else:
            self._timer.stop()
            self._scene.show_markers("trail", "")
            for each in (self._subscriber, self._publisher):
                if each is not None:
                    each.unregister()
            self._subscriber = self._publisher = self._published = None
        self._follow()

    def _follow(self) -> None:
        """Unsubscribes from other robots' odometry; `_update` subscribes to the selected one's.

        So all that the window has of a topic is closed before it is opened with another type:
        rospy's subscribers of a topic share the first one's class.
        """
        model = self._models.get(self._selection.name) if self._subscriber is not None else None
        wanted = (self._selection.name, odometry_topic(model))
        if self._followed != wanted and self._odometry is not None:
            self._odometry.unregister()
            self._odometry = None
        self._followed = wanted

    def _see(self, message: ModelStates) -> None:
        with self._lock:
            for state in message.models:
                pose = (state.pose.x, state.pose.y, state.pose.theta)
                self._trails.see(state.name, message.stamp.to_sec(), pose)

    def _believe(self, message: Odometry, name: str) -> None:
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        pose = (position.x, position.y, 2 * math.atan2(turn.z, turn.w))
        with self._lock:
            self._trails.believe(name, message.header.stamp.to_sec(), pose)

    def _update(self) -> None:
        """Publishes the lines, if they have changed."""
        assert self._publisher is not None
        name, topic = self._followed
        if topic and self._odometry is None:
            self._odometry = rospy.Subscriber(topic, Odometry, self._believe, name, queue_size=10)
        with self._lock:
            lines = (self._trails.of(name), self._trails.belief_of(name))
            revisions = (name, *(line.revision for line in lines))
            if revisions == self._published:
                return
            self._published = revisions
            markers = [
                _marker(index, line, color)
                for index, (line, color) in enumerate(zip(lines, (_TRUTH, _BELIEF)))
            ]
        for marker in markers:
            self._publisher.publish(marker)


def odometry_topic(model: Optional[Model]) -> str:
    """The topic of a model's odometry, which is not the ground truth; empty if it has none."""
    topics: List[str] = [
        topic.name
        for topic in (model.topics if model is not None else ())
        if topic.is_published and topic.type == "nav_msgs/Odometry"
    ]
    return next((topic for topic in topics if "ground_truth" not in topic), "")


def _marker(index: int, line: Trail, color: ColorRGBA) -> Marker:
    marker = Marker(ns="trail", id=index, type=Marker.LINE_STRIP, color=color)
    marker.header.frame_id = _FRAME
    marker.pose.orientation.w = 1.0
    marker.scale.x = _WIDTH
    points = line.points
    marker.action = Marker.ADD if len(points) > 1 else Marker.DELETE
    height = 0.02 + 0.01 * index
    marker.points = [Point(x, y, height) for x, y in points]
    return marker

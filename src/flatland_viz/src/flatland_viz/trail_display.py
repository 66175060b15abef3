"""Lines of the selected robot's way and of its odometry, in the map."""

import math
import threading
from typing import Dict, Optional, Tuple

import rospy
from flatland_msgs.msg import ModelStates
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from python_qt_binding.QtCore import QObject, QTimer
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from flatland_viz.model_list import Model
from flatland_viz.selection import Selection
from flatland_viz.trail import Line, Trail
from flatland_viz.world_displays import WorldDisplays

_FRAME = "map"
_PERIOD = 200  # ms
_WIDTH = 0.05  # m
_TRUTH = ColorRGBA(0.0, 0.45, 0.7, 1.0)
_BELIEF = ColorRGBA(0.9, 0.62, 0.0, 1.0)


class TrailDisplay(QObject):
    """Subscribes to models and odometry while it is switched on, and to nothing otherwise.

    Args:
        displays: displays to draw the lines in.
        selection: selected robot.
    """

    def __init__(self, displays: WorldDisplays, selection: Selection) -> None:
        super().__init__()
        self._displays = displays
        self._selection = selection
        self._models: Dict[str, Model] = {}
        self._lock = threading.Lock()  # rospy calls back on threads of its own
        self._trail = Trail()
        self._followed: Tuple[str, str] = ("", "")  # a model, and the topic of its odometry
        self._odometry: Optional[rospy.Subscriber] = None
        self._states: Optional[rospy.Subscriber] = None
        self._publisher: Optional[rospy.Publisher] = None
        self._timer = QTimer(self, interval=_PERIOD)
        self._timer.timeout.connect(self._update)
        selection.changed.connect(lambda name: self._follow())

    def set_models(self, models: Dict[str, Model]) -> None:
        """Sets the models in the world."""
        self._models = models
        self._follow()

    def switch(self, is_on: bool) -> None:
        """Begins with empty lines, or ends."""
        if is_on:
            topic = rospy.resolve_name("~trail")
            self._publisher = rospy.Publisher(topic, Marker, queue_size=4, latch=True)
            self._displays.show_markers("trail", topic)
            self._states = rospy.Subscriber(
                "flatland_server/model_states", ModelStates, self._see, queue_size=10
            )
            self._timer.start()
        else:
            self._timer.stop()
            self._displays.show_markers("trail", "")
            for each in (self._states, self._publisher):
                if each is not None:
                    each.unregister()
            self._states = self._publisher = None
        self._follow()

    def _follow(self) -> None:
        """Unsubscribes from other robots' odometry; `_update` subscribes to the selected one's.

        So all that the window has of a topic is closed before it is opened with another type:
        rospy's subscribers of a topic share the first one's class.
        """
        name = self._selection.name if self._states is not None else ""
        wanted = (name, odometry_topic(self._models.get(name)))
        if wanted == self._followed:
            return
        if self._odometry is not None:
            self._odometry.unregister()
            self._odometry = None
        with self._lock:
            self._followed, self._trail = wanted, Trail()

    def _see(self, message: ModelStates) -> None:
        with self._lock:
            for state in message.models:
                if state.name == self._followed[0]:
                    pose = (state.pose.x, state.pose.y, state.pose.theta)
                    self._trail.see(message.stamp.to_sec(), pose)

    def _believe(self, message: Odometry, topic: str) -> None:
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        pose = (position.x, position.y, 2 * math.atan2(turn.z, turn.w))
        with self._lock:
            if topic == self._followed[1]:
                self._trail.believe(message.header.stamp.to_sec(), pose)

    def _update(self) -> None:
        """Publishes the lines that have changed."""
        assert self._publisher is not None
        topic = self._followed[1]
        if topic and self._odometry is None:
            self._odometry = rospy.Subscriber(topic, Odometry, self._believe, topic, queue_size=10)
        with self._lock:
            lines = ((self._trail.truth, _TRUTH), (self._trail.belief, _BELIEF))
            markers = [
                _marker(index, line, color)
                for index, (line, color) in enumerate(lines)
                if line.has_changed
            ]
            self._trail.truth.has_changed = self._trail.belief.has_changed = False
        for marker in markers:
            self._publisher.publish(marker)


def odometry_topic(model: Optional[Model]) -> str:
    """The topic of a model's odometry, which is not the ground truth; empty if it has none."""
    for topic in model.topics if model is not None else ():
        is_odometry = topic.is_published and topic.type == "nav_msgs/Odometry"
        if is_odometry and "ground_truth" not in topic.name:
            return topic.name
    return ""


def _marker(index: int, line: Line, color: ColorRGBA) -> Marker:
    marker = Marker(ns="trail", id=index, type=Marker.LINE_STRIP, color=color)
    marker.header.frame_id = _FRAME
    marker.pose.orientation.w = 1.0
    marker.scale.x = _WIDTH
    points = line.points
    marker.action = Marker.ADD if len(points) > 1 else Marker.DELETE
    height = 0.02 + 0.01 * index
    marker.points = [Point(x, y, height) for x, y in points]
    return marker

"""Warns of other nodes that place an odometry frame which the server places in the map.

With `~map_to_odom`, the server sends map -> odom. A localiser (AMCL, gmapping, a filter) sends it,
too, and viewers and costmaps would see the robot jump between both.
"""

import logging
import time
from functools import partial
from typing import Any, Callable, Collection, Dict, List, Set

import rospy
from tf2_msgs.msg import TFMessage

from flatland_server.config.ros_names import tf_topics
from flatland_server.transport.frame_registry import OdometryFrame

logger = logging.getLogger(__name__)

_LIMIT = 60.0
"""Real time for which transforms of a node are looked at: a localiser starts with a scan [s]."""


class OtherLocalisers:
    """Subscribes to transforms while there is a node that has not sent them for long.

    Args:
        frames: returns the frames that the server places, each with the namespace of its topics.
    """

    def __init__(self, frames: Callable[[], Collection[OdometryFrame]]) -> None:
        self._frames = frames
        self._begin: Dict[str, float] = {}  # when each node was seen first
        self._warned: Set[str] = set()
        self._subscribers: Dict[str, rospy.Subscriber] = {}  # by topic

    def follow(self, publishers: List[Any]) -> None:
        """Begins or ends the subscriptions.

        Args:
            publishers: as the master tells them: lists of a topic and its nodes.
        """
        now = time.monotonic()
        namespaces = {
            rospy.resolve_name(topic): namespace
            for namespace, _ in self._frames()
            for topic in tf_topics(namespace)
        }
        nodes = {node for topic, nodes in publishers if topic in namespaces for node in nodes}
        self._begin = {
            node: self._begin.get(node, now) for node in nodes if node != rospy.get_name()
        }
        self._warned &= nodes
        if not any(now - begin < _LIMIT for begin in self._begin.values()):
            while self._subscribers:
                self._subscribers.popitem()[1].unregister()
            return
        for topic in namespaces.keys() - self._subscribers.keys():
            self._subscribers[topic] = rospy.Subscriber(
                topic, TFMessage, partial(self._receive, namespaces[topic])
            )

    def _receive(self, namespace: str, message: Any) -> None:
        node = message._connection_header["callerid"]
        if node == rospy.get_name() or node in self._warned:
            return
        children = {each.child_frame_id.lstrip("/") for each in message.transforms}
        placed = {frame for found, frame in self._frames() if found == namespace}
        for frame in sorted(children & placed):
            self._warned.add(node)
            logger.warning(
                'both %s and the server place the frame "%s": start server.launch with '
                "map_to_odom:=false, or do not localise (robot.launch navigator:=waypoints)",
                node,
                frame,
            )

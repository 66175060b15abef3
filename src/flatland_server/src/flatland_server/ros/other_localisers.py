"""Warns of other nodes that place an odometry frame which the server places in the map.

With `~map_to_odom`, the server sends map -> odom. A localiser (AMCL, gmapping, a filter) sends it,
too, and viewers and costmaps would see the robot jump between both.
"""

import logging
import time
from typing import Any, Callable, Collection, Dict, List, Set

import rospy
from tf2_msgs.msg import TFMessage

logger = logging.getLogger(__name__)

_TOPICS = ("/tf", "/tf_static")
_LIMIT = 60.0
"""Real time for which transforms of a node are looked at: a localiser starts with a scan [s]."""


class OtherLocalisers:
    """Subscribes to transforms while there is a node that has not sent them for long.

    Args:
        frames: returns the frames that the server places.
    """

    def __init__(self, frames: Callable[[], Collection[str]]) -> None:
        self._frames = frames
        self._begin: Dict[str, float] = {}  # when each node was seen first
        self._warned: Set[str] = set()
        self._subscribers: List[rospy.Subscriber] = []

    def follow(self, publishers: List[Any]) -> None:
        """Begins or ends the subscriptions.

        Args:
            publishers: as the master tells them: lists of a topic and its nodes.
        """
        now = time.monotonic()
        nodes = {node for topic, nodes in publishers if topic in _TOPICS for node in nodes}
        self._begin = {
            node: self._begin.get(node, now) for node in nodes if node != rospy.get_name()
        }
        self._warned &= nodes
        if not any(now - begin < _LIMIT for begin in self._begin.values()):
            while self._subscribers:
                self._subscribers.pop().unregister()
        elif not self._subscribers:
            self._subscribers = [rospy.Subscriber(t, TFMessage, self._receive) for t in _TOPICS]

    def _receive(self, message: Any) -> None:
        node = message._connection_header["callerid"]
        if node == rospy.get_name() or node in self._warned:
            return
        children = {each.child_frame_id.lstrip("/") for each in message.transforms}
        for frame in sorted(children & set(self._frames())):
            self._warned.add(node)
            logger.warning(
                'both %s and the server place the frame "%s": start server.launch with '
                "map_to_odom:=false, or do not localise (robot.launch navigator:=waypoints)",
                node,
                frame,
            )

"""Warns of other nodes that publish what the server publishes: a plugin's topic, or a frame.

robot_localization's default topic, odometry/filtered, is that of the odometry too: subscribers
would get both by turns, and the filter its own output. With `~map_to_odom`, the server sends map ->
odom. A localiser (AMCL, gmapping, a filter) sends it, too, and viewers and costmaps would see the
robot jump between both.
"""

import logging
import threading
import time
from functools import partial
from typing import Any, Callable, Collection, Dict, List, Mapping, Optional, Set, Tuple

import rosgraph
import rospy
from tf2_msgs.msg import TFMessage

from flatland_server.config.ros_names import tf_topics
from flatland_server.ros.rospy_patches.master_calls import NO_ANSWER, Master
from flatland_server.transport.claims import OdometryFrame

logger = logging.getLogger(__name__)

_PERIOD = 5.0
"""Real time between two looks at the master's list of publishers [s]."""
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


class OtherPublishers:
    """Looks for other publishers in a thread of its own, until the node ends.

    Transforms and /diagnostics are left out: they have several publishers.

    Args:
        counts: the number of publishers that plugins have of each topic.
        master: the ROS master to ask.
        localisers: gets the publishers of all topics; None unless the server places odometry
            frames.
    """

    def __init__(
        self,
        counts: Mapping[str, int],
        master: Master,
        localisers: Optional[OtherLocalisers] = None,
    ) -> None:
        self._counts = counts
        self._master = master
        self._localisers = localisers
        self._known: Set[Tuple[str, str]] = set()
        self._end = threading.Event()
        rospy.on_shutdown(self._end.set)

    def start(self) -> None:
        """Starts the thread."""
        threading.Thread(target=self._watch, name="other publishers", daemon=True).start()

    def _watch(self) -> None:
        while not self._end.wait(_PERIOD):
            self.check()

    def check(self) -> None:
        """Warns of publishers that were not there at the last check."""
        try:
            publishers = self._master.publishers()
        except NO_ANSWER:
            return
        if self._localisers is not None:
            self._localisers.follow(publishers)
        found = self._others(publishers)
        for topic, node in sorted(found - self._known):
            logger.warning(
                "%s is also published by %s: subscribers get both by turns; remap one of them, or "
                'set the plugin\'s key, such as "odom_pub: wheel_odom"',
                topic,
                node,
            )
        self._known = found

    def _others(self, publishers: List[Any]) -> Set[Tuple[str, str]]:
        me = rospy.get_name()
        counts = list(self._counts.items())
        shared = ("/tf", "/diagnostics")
        mine = {topic for topic, count in counts if count > 0 and not topic.endswith(shared)}
        return {(t, node) for t, nodes in publishers if t in mine for node in nodes if node != me}


def watch(counts: Mapping[str, int], localisers: Optional[OtherLocalisers]) -> None:
    """Starts to watch the publishers of some topics; see `OtherPublishers`."""
    OtherPublishers(counts, Master(rosgraph.get_master_uri()), localisers).start()

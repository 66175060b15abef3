"""Warns of other nodes that publish on a topic of a plugin.

robot_localization's default topic, odometry/filtered, is that of the odometry too: subscribers
would get both by turns, and the filter its own output.
"""

import logging
import threading
from typing import Any, List, Mapping, Optional, Set, Tuple

import rosgraph
import rospy

from flatland_server.ros.other_localisers import OtherLocalisers
from flatland_server.ros.rospy_patches.master_calls import NO_ANSWER, Master

logger = logging.getLogger(__name__)

_PERIOD = 5.0
"""Real time between two looks at the master's list of publishers [s]."""


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

"""Running the nodes of this package."""

from typing import Callable, Protocol

import rospy
from nav_msgs.msg import Odometry

from flatland_navigation.awaited_topics import wait_for_messages
from flatland_server import FlatlandError
from flatland_server.ros import init_node


class RobotNode(Protocol):
    """A node that does nothing before its robot's odometry comes.

    Attributes:
        odometry_topic: the topic of the odometry.
    """

    odometry_topic: str


def run_node(name: str, start: Callable[[], RobotNode]) -> int:
    """Runs a node until it is shut down. Returns its exit code.

    Args:
        name: the node's name.
        start: returns what the node consists of; a FlatlandError is its reason not to start.
    """
    init_node(name)
    try:
        node = start()
    except FlatlandError as error:
        for line in str(error).splitlines():
            rospy.logfatal("%s", line)
        return 1
    wait_for_messages({node.odometry_topic: Odometry})
    rospy.spin()
    return 0

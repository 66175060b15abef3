"""Running the nodes of this package."""

from typing import Callable

import rospy

from flatland_server import FlatlandError


def run_node(name: str, start: Callable[[], object]) -> int:
    """Runs a node until it is shut down. Returns its exit code.

    Args:
        name: of the node.
        start: returns what the node consists of; a FlatlandError is its reason not to start.
    """
    rospy.init_node(name)
    try:
        node = start()
    except FlatlandError as error:
        for line in str(error).splitlines():
            rospy.logfatal("%s", line)
        return 1
    rospy.spin()
    del node
    return 0

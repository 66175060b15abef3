"""A longer queue for incoming connections.

rospy's socket keeps at most five connections waiting to be accepted. A subscriber to hundreds of
topics of this node, such as a recorder of a hundred robots, opens all of its connections at once;
those that do not fit are retried by the system after one second, two seconds, four seconds etc.
"""

from typing import Any, Dict

from rospy.impl import tcpros_base

from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

REQUIREMENTS = (
    Requirement("rospy.impl.tcpros_base:start_tcpros_server", ()),
    Requirement("rospy.impl.tcpros_base:_tcpros_server"),
    Requirement("rospy.impl.tcpros_base:TCPROSServer.__init__", uses=("tcp_ros_server",)),
    Requirement("rospy.impl.tcpros_base:TCPServer.__init__", uses=("server_sock",)),
)

_BACKLOG = 1024
"""Connections that may wait to be accepted; the system may allow fewer."""


def install() -> Dict[str, Any]:
    """Enlarges the queue of rospy's socket, which it opens if need be. Replaces no call."""
    check_all(REQUIREMENTS)
    tcpros_base.start_tcpros_server()  # as the first subscriber would
    tcpros_base._tcpros_server.tcp_ros_server.server_sock.listen(_BACKLOG)
    return {}

"""Room for many listeners who connect at once.

rospy has the system keep five connections that nobody has come to accept yet. Who subscribes to
hundreds of topics of a node, as a listener to a hundred robots does, asks for all of them in a
moment; those that find no room try again after a second, two seconds, four seconds and so on.
"""

import logging

from rospy.impl import tcpros_base

logger = logging.getLogger(__name__)

_BACKLOG = 1024
"""Connections that may wait to be accepted; the system may allow fewer."""


def enlarge_tcpros_backlog() -> None:
    """Lets so many connect to this process at once. To be called after `rospy.init_node`."""
    try:
        tcpros_base.start_tcpros_server()  # as the first listener would
        tcpros_base._tcpros_server.tcp_ros_server.server_sock.listen(_BACKLOG)
    except (AttributeError, OSError) as error:  # another rospy than we know: as it is without us
        logger.warning("when many listeners connect at once, some will have to wait: %s", error)

"""Publishing bytes: writes a serialized message directly to the connections of a topic.

`rospy.Publisher.publish` would take a lock, copy the message through a buffer and count it.
"""

from typing import Any, Dict

import rospy

from flatland_server.ros.rospy_patches.public_rospy import LENGTH
from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

REQUIREMENTS = (
    Requirement("rospy.topics:Topic.__init__", uses=("impl",)),
    Requirement("rospy.topics:_TopicImpl.__init__", uses=("connections", "closed")),
    Requirement("rospy.topics:_TopicImpl.remove_connection", ("self", "c")),
    Requirement("rospy.impl.tcpros_pubsub:QueuedConnection.write_data", ("self", "data")),
)


def install() -> Dict[str, Any]:
    """Checks the requirements. Returns the calls that this replaces."""
    check_all(REQUIREMENTS)
    return {"is_connected": is_connected, "send_bytes": send_bytes, "send_framed": send_framed}


def is_connected(publisher: rospy.Publisher) -> bool:
    """True if a topic has a subscriber; without rospy's lock."""
    topic = publisher.impl
    return topic is not None and bool(topic.connections)


def send_bytes(publisher: rospy.Publisher, data: bytes) -> None:
    """Publishes a serialized message. Not for latched topics."""
    send_framed(publisher, LENGTH.pack(len(data)) + data)


def send_framed(publisher: rospy.Publisher, framed: bytes) -> None:
    """Publishes one or more serialized messages, each preceded by its length."""
    topic = publisher.impl
    if topic is None or topic.closed:
        return
    for connection in topic.connections:
        try:
            connection.write_data(framed)
        except Exception:  # like rospy's own publish: a connection that fails is dropped
            connection.close()
            topic.remove_connection(connection)

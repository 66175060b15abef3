"""Running the nodes of this package."""

import time
from typing import Any, Callable, Dict, Mapping, Protocol

import rospy
from nav_msgs.msg import Odometry

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


_PERIOD = 10.0
"""Real time between two warnings [s]; half of it passes before the first."""
_LOOK_PERIOD = 0.1  # s of real time


def wait_for_messages(topics: Mapping[str, Any]) -> None:
    """Waits until each topic has brought a message, or the node ends; warns of those without.

    Args:
        topics: the classes of the messages by the names of their topics.
    """
    missing: Dict[str, Any] = dict(topics)
    subscribers = [
        rospy.Subscriber(name, kind, lambda _, name: missing.pop(name, None), name)
        for name, kind in topics.items()
    ]
    next_warning = time.monotonic() + 0.5 * _PERIOD
    while missing and not rospy.is_shutdown():
        if time.monotonic() >= next_warning:
            next_warning += _PERIOD
            for name, subscriber in zip(topics, subscribers):
                if name in missing:
                    rospy.logwarn("%s", _warning(subscriber))
        time.sleep(_LOOK_PERIOD)
    for subscriber in subscribers:
        subscriber.unregister()


def _warning(subscriber: rospy.Subscriber) -> str:
    topic, kind = subscriber.resolved_name, subscriber.type
    text = f"waiting for {kind} on {topic}"
    if subscriber.get_num_connections():
        return text
    others = [other for other, each in rospy.get_published_topics() if each == kind]
    hint = f" (there is {', '.join(sorted(others))})" if others else ""
    return f"{text}, which has no publisher{hint}"

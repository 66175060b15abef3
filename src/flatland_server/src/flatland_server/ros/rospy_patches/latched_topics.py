"""Latched topics that can drop an outdated message.

A latched topic keeps its last message for later subscribers, and rospy has no way to withdraw it. A
topic that publishes only while it has subscribers would send an old state to the next one.
"""

from typing import Any, Dict

import rospy

from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

REQUIREMENTS = (
    Requirement("rospy.topics:Topic.__init__", uses=("impl",)),
    Requirement("rospy.topics:_PublisherImpl.__init__", uses=("latch",)),
    Requirement("rospy.topics:_PublisherImpl.add_connection", uses=("latch",)),
)


def install() -> Dict[str, Any]:
    """Checks the requirements. Returns the calls that this replaces."""
    check_all(REQUIREMENTS)
    return {"forget_latched": forget_latched}


def forget_latched(publisher: rospy.Publisher) -> None:
    """Makes a latched topic forget its last message."""
    topic = publisher.impl
    if topic is not None:
        topic.latch = None

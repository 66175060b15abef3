"""This process's simulated time, set directly.

With use_sim_time, rospy subscribes to /clock: in the process that publishes /clock, every tick
would travel through a socket and two threads to set a variable.
"""

from typing import Any, Dict, Optional

import rospy
from rospy import rostime
from rospy.impl import simtime

from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

REQUIREMENTS = (
    Requirement("rospy.impl.simtime:init_simtime", uses=("Subscriber", "_clock_sub")),
    Requirement("rospy.rostime:_rostime_current"),
    Requirement("rospy.rostime:get_rostime", uses=("_rostime_current",)),
    Requirement("rospy.rostime:get_rostime_cond", ()),
)

_new = rospy.Time.__new__


def install() -> Dict[str, Any]:
    """Checks the requirements. Returns the call that this replaces."""
    check_all(REQUIREMENTS)
    return {"take_over_time": take_over_time}


def take_over_time() -> Optional["LocalTime"]:
    """Ends rospy's subscription to /clock, if it has one."""
    subscription = getattr(simtime, "_clock_sub", None)  # set by init_node, with use_sim_time
    if subscription is None:
        return None
    subscription.unregister()
    return LocalTime()


class LocalTime:
    """Sets rospy's time in this process."""

    def set(self, seconds: int, nanoseconds: int) -> None:
        """Sets what `rospy.Time.now()` returns."""
        now = _new(rospy.Time)  # __init__ would take longer than the rest of a tick
        now.secs, now.nsecs = seconds, nanoseconds
        rostime._rostime_current = now

    def notify(self) -> None:
        """Wakes the threads that wait for a time."""
        condition = rostime.get_rostime_cond()
        with condition:
            condition.notify_all()

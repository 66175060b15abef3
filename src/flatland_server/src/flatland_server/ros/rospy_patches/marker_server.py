"""Interactive markers without the library's thread, which wakes at every step of simulated time."""

import threading
from typing import Any, Dict

import rospy

from flatland_server.ros.rospy_patches import public_rospy
from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

_SERVER = "interactive_markers.interactive_marker_server:InteractiveMarkerServer"

REQUIREMENTS = (
    Requirement(f"{_SERVER}.__init__", uses=("Timer", "keepAlive", "marker_contexts")),
    Requirement(f"{_SERVER}.keepAlive", ("self", "msg")),
    Requirement(
        "interactive_markers.interactive_marker_server:MarkerContext.__init__",
        uses=("last_feedback",),
    ),
    Requirement("rospy:Timer.shutdown", ("self",)),
)

_LONG_AGO = rospy.Duration(-3600)
"""Stands for the time of a marker's last feedback, which the library subtracts from the present.

A duration, since no rospy.Time precedes 0: in the first second of simulated time, 0 is recent.
"""


def install() -> Dict[str, Any]:
    """Checks the requirements. Returns the class that this replaces."""
    check_all(REQUIREMENTS)
    return {"marker_server": MarkerServer}


class MarkerServer(public_rospy.MarkerServer):
    """Sends keep-alive messages only when asked to.

    Args:
        topic_namespace: of its topics.
    """

    def __init__(self, topic_namespace: str) -> None:
        others = set(threading.enumerate())
        super().__init__(topic_namespace)
        for thread in threading.enumerate():
            if thread not in others and isinstance(thread, rospy.Timer):
                thread.shutdown()

    def keep_alive(self) -> None:
        self.keepAlive(None)

    def allow_drag(self, name: str) -> None:
        context = self.marker_contexts.get(name)
        if context is not None:
            context.last_feedback = _LONG_AGO

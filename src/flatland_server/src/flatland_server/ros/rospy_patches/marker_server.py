"""Interactive markers without the library's thread, which wakes at every step of simulated time.

It also leaves out the poses that the library sends back to a client that drags.
"""

import threading
from typing import Any, Dict

import rospy

from flatland_server.ros.rospy_patches import public_rospy
from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

_SERVER = "interactive_markers.interactive_marker_server:InteractiveMarkerServer"

REQUIREMENTS = (
    Requirement(
        f"{_SERVER}.__init__",
        uses=("Timer", "keepAlive", "marker_contexts", "pending_updates", "mutex"),
    ),
    Requirement(f"{_SERVER}.processFeedback", ("self", "feedback"), uses=("doSetPose",)),
    Requirement(f"{_SERVER}.doSetPose", ("self", "update", "name", "pose", "header")),
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

    def setPose(self, name: str, pose: Any, header: Any = None) -> bool:  # noqa: N802
        """As the library's, with the marker's own header."""
        with self.mutex:
            context = self.marker_contexts.get(name)
            if context is None:
                return False
            header = header or context.int_marker.header
            super().doSetPose(self.pending_updates.get(name), name, pose, header)
        return True

    def doSetPose(self, update: Any, name: str, pose: Any, header: Any) -> None:  # noqa: N802
        """Ignores the pose in a client's feedback, for which the library calls this.

        The library would send it with the next change of any marker. rviz keeps it for the end of
        the drag, and puts the model back there.
        """

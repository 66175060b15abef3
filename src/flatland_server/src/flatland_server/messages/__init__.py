"""Messages: their types by name, with ROS or without, and messages made of our values. No rospy.

from flatland_server import messages

Twist = messages.get("geometry_msgs/Twist")
Load = messages.add("my_plugins/Load", "float64 mass")
"""

from typing import TYPE_CHECKING, Any, Callable

from flatland_server.messages.conversions import fill_pose, fill_twist, header, ros_time, yaw_of
from flatland_server.messages.message_types import TYPES, add, get
from flatland_server.messages.stamps import stamp_of

if TYPE_CHECKING:
    Duration: Callable[..., Any]
    Time: Callable[..., Any]

__all__ = [
    "Duration",
    "Time",
    "add",
    "fill_pose",
    "fill_twist",
    "get",
    "header",
    "ros_time",
    "stamp_of",
    "yaw_of",
]


def __getattr__(name: str) -> Any:
    if name in ("Duration", "Time"):
        return getattr(TYPES, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

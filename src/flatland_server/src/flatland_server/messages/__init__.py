"""Messages: their types by name, with ROS or without, and messages made of our values. No rospy.

from flatland_server import messages

Twist = messages.get("geometry_msgs/Twist")
Load = messages.add("my_plugins/Load", "float64 mass")
"""

from typing import TYPE_CHECKING, Any, Callable

from flatland_server.messages import service_types as service_types
from flatland_server.messages.conversions import (
    fill_pose,
    fill_twist,
    header,
    ros_time,
    stamp_of,
    yaw_of,
)
from flatland_server.messages.conversions import set_stamp_offset as set_stamp_offset
from flatland_server.messages.conversions import stamp_offset as stamp_offset
from flatland_server.messages.conversions import transform_of as transform_of
from flatland_server.messages.definition import INTEGERS as INTEGERS
from flatland_server.messages.definition import NUMBERS as NUMBERS
from flatland_server.messages.definition import FieldType as FieldType
from flatland_server.messages.message_types import TYPES as TYPES
from flatland_server.messages.message_types import add, get
from flatland_server.messages.message_types import deserialized as deserialized
from flatland_server.messages.service_types import ServiceType as ServiceType
from flatland_server.messages.standard_definitions import written_out as written_out
from flatland_server.messages.wire_form import LENGTH as LENGTH
from flatland_server.messages.wire_form import WRONG_VALUE as WRONG_VALUE
from flatland_server.messages.wire_form import ObjectBudget as ObjectBudget
from flatland_server.messages.wire_form import objects_in as objects_in
from flatland_server.messages.wire_form import serialized as serialized

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

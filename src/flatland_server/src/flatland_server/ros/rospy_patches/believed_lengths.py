"""Messages with arrays of empty items: their length is checked before anything is made.

rospy reads messages by the code that genpy has made for their types. If the items of an
array have numbers or texts, a false length ends with an error when the data end. Items without, as
in `std_msgs/Empty[]` or of a type with nothing but `uint8[16]`, are made as often as the length
says: four bytes take gigabytes and minutes. Types with such arrays are read by our own code here;
all others by rospy.
"""

from functools import lru_cache, partial
from typing import Any, Callable, Dict

import rospy.msg
from rospy.impl import tcpros_base

from flatland_server.messages.message_types import deserialized, get
from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

_PARAMETERS = ("b", "msg_queue", "data_class", "queue_size", "max_msgs", "start")

REQUIREMENTS = (
    Requirement("rospy.msg:deserialize_messages", _PARAMETERS, uses=("deserialize",)),
    Requirement("rospy.impl.tcpros_base:deserialize_messages", _PARAMETERS),
    Requirement(
        "rospy.impl.tcpros_base:TCPROSTransportProtocol.read_messages",
        uses=("deserialize_messages", "recv_data_class"),
    ),
    Requirement(
        "rospy.impl.tcpros_service:TCPROSServiceClient.read_messages",
        uses=("_read_ok_byte", "deserialize_messages", "recv_data_class"),
    ),
)


def install() -> Dict[str, Any]:
    """Makes subscribers, services and calls read such types with checks. Replaces no call."""
    check_all(REQUIREMENTS)
    rospys = rospy.msg.deserialize_messages

    def deserialize_messages(b: Any, msg_queue: Any, data_class: Any, **options: Any) -> None:
        rospys(b, msg_queue, _reader(data_class), **options)

    rospy.msg.deserialize_messages = tcpros_base.deserialize_messages = deserialize_messages
    return {}


class _Checked:
    """Stands for a new message where rospy deserializes one."""

    def __init__(self, message_type: Any) -> None:
        self._type = message_type

    def deserialize(self, data: bytes) -> Any:
        return deserialized(self._type, data)


@lru_cache(maxsize=None)
def _reader(message_type: Any) -> Callable[[], Any]:
    return partial(_Checked, message_type) if _believes(message_type) else message_type


def _believes(message_type: Any) -> bool:
    for kind in getattr(message_type, "_slot_types", ()):  # rospy.AnyMsg has none
        base, _, length = kind.partition("[")
        if "/" in base:
            item = get(base)
            if _believes(item) or (length == "]" and _is_made_of_nothing(item)):
                return True
    return False


def _is_made_of_nothing(message_type: Any) -> bool:
    try:
        message_type().deserialize(b"")
    except Exception:  # genpy's, or ours
        return False
    return True

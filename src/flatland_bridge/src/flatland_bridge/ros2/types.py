"""The types of ROS 2: rclpy's classes, and bytes of messages between them and the simulation.

Messages are never objects of rclpy's classes: CDR is made once, by `Ros2Messages`, and published as
it is. Requests and responses of services are objects in rclpy, which converts them from and to CDR.
"""

import importlib
from functools import lru_cache
from typing import Any, Tuple

from rclpy.serialization import deserialize_message, serialize_message
from rclpy.type_support import check_for_type_support

from flatland2d.ros2_messages import Ros2Messages, Ros2Type
from flatland_bridge.graph import BridgeError
from flatland_bridge.plain_form import parse_type
from flatland_server.messages import ServiceType, deserialized, get, serialized


class MissingType(BridgeError):
    """This ROS 2 has no such type. Its only argument is the name."""


class Types:
    """The types that topics and services have in ROS 2.

    Raises:
        MissingPackageError: rosbags is not installed.
    """

    def __init__(self) -> None:
        self._messages = Ros2Messages()

    def topic(self, kind: Any) -> Tuple[Any, Ros2Type]:
        """The class of a topic's messages, and their conversion from and to CDR.

        Args:
            kind: the class of its messages in the simulation.

        Raises:
            MissingType: ROS 2 has no such type.
        """
        return interface(kind._type, "msg"), self._messages.type_of(kind)

    def service(self, kind: ServiceType) -> Any:
        """The class of a service.

        Raises:
            MissingType: ROS 2 has no such type, or one with other fields.
        """
        cls = interface(kind.name, "srv")
        parts = ((cls.Request, kind.request), (cls.Response, kind.response))
        if not all(_has_fields(*part) for part in parts):
            raise MissingType(kind.name)
        return cls

    def request(self, kind: ServiceType, request: Any) -> Any:
        """A request of rclpy as one of the simulation."""
        data = self._messages.type_of(kind.request).from_cdr(serialize_message(request))
        return deserialized(kind.request, data, "strict")

    def response(self, kind: ServiceType, response: Any) -> Any:
        """A response of the simulation as one of rclpy."""
        data = self._messages.type_of(kind.response).to_cdr(serialized(response))
        return deserialize_message(data, interface(kind.name, "srv").Response)


@lru_cache(maxsize=None)
def interface(name: str, folder: str) -> Any:
    """A class of rclpy.

    Args:
        name: name of the type, such as "sensor_msgs/LaserScan".
        folder: "msg", "srv" or "action".

    Raises:
        MissingType: there is none; the package may be one of ROS 1.
    """
    package, _, bare = name.partition("/")
    try:
        cls = getattr(importlib.import_module(f"{package}.{folder}"), bare)
        check_for_type_support(cls)
    except Exception:  # of many kinds, by distribution
        raise MissingType(name) from None
    return cls


def _has_fields(cls: Any, kind: Any) -> bool:
    """True if a class of rclpy has the fields of a type here, also those in its own package.

    Packages have versions: ROS 2 may have an older one than this.
    """
    if list(cls.get_fields_and_field_types()) != [name.lower() for name in kind.__slots__]:
        return False
    package = kind._type.partition("/")[0]
    nested = {parse_type(each).base for each in kind._slot_types}
    return all(
        _has_fields(interface(name, "msg"), get(name))
        for name in nested
        if name.startswith(f"{package}/") and not name.endswith("/Header")
    )

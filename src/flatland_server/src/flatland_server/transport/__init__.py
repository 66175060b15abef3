"""Topics, transforms and parameters: the interface for plugins, and a transport without ROS."""

from flatland_server.transport.frame_registry import OdometryFrame
from flatland_server.transport.local_transport import LocalTransport, Tap, absolute_name
from flatland_server.transport.serialized_transforms import TransformQueue
from flatland_server.transport.served_transport import ServedTransport
from flatland_server.transport.topic_registry import ANY_TYPE, type_name
from flatland_server.transport.transport import Publisher, Subscription, Transport

__all__ = [
    "ANY_TYPE",
    "LocalTransport",
    "OdometryFrame",
    "Publisher",
    "ServedTransport",
    "Subscription",
    "Tap",
    "TransformQueue",
    "Transport",
    "absolute_name",
    "type_name",
]

"""Topics, transforms and parameters: the interface for plugins, and a transport without ROS."""

from flatland_server.transport.claims import ANY_TYPE, OdometryFrame, type_name
from flatland_server.transport.local_transport import LocalTransport, Tap, absolute_name
from flatland_server.transport.served_transport import ServedTransport
from flatland_server.transport.transforms import TransformQueue
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

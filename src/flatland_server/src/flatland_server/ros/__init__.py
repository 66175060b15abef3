"""The ROS node: the only part of the server that imports rospy."""

try:
    import rospy  # noqa: F401
except ImportError as _error:
    from flatland_server.wrong_python import wrong_python as _wrong_python

    raise _wrong_python(_error) from None

from flatland_server.ros.node import init_node

__all__ = ["init_node"]

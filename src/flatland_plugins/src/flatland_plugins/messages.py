"""Functions that fill messages, for plugins that import them from here: see flatland_server."""

from flatland_server import fill_pose, fill_twist, header, ros_time

__all__ = ["fill_pose", "fill_twist", "header", "ros_time"]

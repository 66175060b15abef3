"""ROS messages from Flatland's values."""

from flatland_server import fill_pose, fill_twist, header, ros_time

__all__ = ["fill_pose", "fill_twist", "header", "ros_time"]

"""Makes ROS messages of Flatland's values, as objects or serialized. Needs no rospy."""

from flatland_server.messages.conversions import fill_pose, fill_twist, header, ros_time

__all__ = ["fill_pose", "fill_twist", "header", "ros_time"]

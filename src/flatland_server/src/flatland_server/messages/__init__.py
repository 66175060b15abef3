"""ROS messages from Flatland's values, as objects and as bytes; no master and no rospy needed."""

from flatland_server.messages.conversions import fill_pose, fill_twist, header, ros_time

__all__ = ["fill_pose", "fill_twist", "header", "ros_time"]

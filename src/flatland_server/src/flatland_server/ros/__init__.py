"""The ROS node: the only part of the server that imports rospy."""

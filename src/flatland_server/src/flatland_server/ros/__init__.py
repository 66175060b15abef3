"""The ROS edge: the only part of the server that imports rospy."""

"""The node flatland_server of ROS 2, which is in flatland2d."""

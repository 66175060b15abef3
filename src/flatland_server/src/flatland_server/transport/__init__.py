"""Topics, transforms and parameters: what plugins use of them, and a transport without ROS."""

"""Topics, transforms and parameters: the interface for plugins, and a transport without ROS."""

"""The seam between plugins and ROS: nodes, publishers, and a transport without ROS."""

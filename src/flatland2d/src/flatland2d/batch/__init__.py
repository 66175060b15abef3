"""Many environments of one world, each with a robot, stepped in one call; no ROS."""

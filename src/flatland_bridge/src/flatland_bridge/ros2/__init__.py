"""Topics, services and parameters of a simulation for nodes of ROS 2, by rclpy."""

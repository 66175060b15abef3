"""Command-line tools that check and draw worlds without a ROS master."""

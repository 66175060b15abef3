"""Commands for a user's files: checking and drawing worlds, without a ROS master."""

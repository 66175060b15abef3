"""The topics and services of a server that are not plugins', over any transport. No rospy."""

"""Flatland as a library: a world, its time and its topics in a Python program, without ROS."""

"""Faster paths through rospy than its public interface offers, each behind a check.

Everything in flatland_server that reaches into rospy lies in this package.
It is written for rospy 1.15 to 1.17 (ROS Noetic). `install` checks, for each patch, that the
attributes and signatures it relies on exist. A patch that fails this check is left out: the server
then does the same through rospy's public interface, at a cost that is logged.
"""

from flatland_server.ros.rospy_patches.rospy_calls import PATCHES, RospyCalls, install

__all__ = ["PATCHES", "RospyCalls", "install"]

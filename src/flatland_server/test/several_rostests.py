#!/usr/bin/python3
"""Runs rostests in one process with one launch; rostest repeats the launch for each process.

The arguments are their modules, in this order: `args="services_rostest server_rostest"`.
"""

import sys

import rospy
import rostest


def load_tests(loader, _tests, _pattern):
    """What unittest calls instead of looking for tests in this module."""
    names = [word for word in rospy.myargv()[1:] if not word.startswith("-")]
    return loader.loadTestsFromNames(names)


if __name__ == "__main__":
    # rospy's own subscription to /clock keeps one message only, and drops the others of ours.
    rospy.init_node("several_rostests", disable_rostime=True)
    rostest.rosrun("flatland_server", "several_rostests", "__main__", sys.argv)

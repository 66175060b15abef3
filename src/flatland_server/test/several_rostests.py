#!/usr/bin/python3
"""Runs rostests in one process with one launch; rostest repeats the launch for each process.

The arguments are their modules, in this order: `args="services_rostest server_rostest"`.
"""

import sys

import rospy
import rostest


def load_tests(loader, _tests, _pattern):
    """Loads the tests of the given modules, by unittest's load_tests protocol."""
    names = [word for word in rospy.myargv()[1:] if not word.startswith("-")]
    return loader.loadTestsFromNames(names)


if __name__ == "__main__":
    # rospy's own subscription to /clock has a queue of one message, which ours would share.
    rospy.init_node("several_rostests", disable_rostime=True)
    rostest.rosrun("flatland_server", "several_rostests", "__main__", sys.argv)

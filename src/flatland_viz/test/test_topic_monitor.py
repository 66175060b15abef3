"""The panel's readings of topics that the trail subscribes to as well, over a real master."""

import json
import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

PROGRAM = """
import json
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from flatland_viz.model_list import Topic
from flatland_viz.topic_monitor import TopicMonitor
from waiting import wait_until

rospy.init_node("window")
monitor = TopicMonitor()


def read(kind, message):
    publisher = rospy.Publisher("/odom", kind, queue_size=1)
    monitor.watch([Topic("/odom", kind._type, True, "drive")])
    trail = rospy.Subscriber("/odom", kind, seen.append)

    def value():
        publisher.publish(message)
        return seen and monitor.readings(0.0)["/odom"].value

    try:
        return wait_until(value, "a message", 10.0), type(seen[-1]).__name__
    finally:
        trail.unregister()
        publisher.unregister()
        seen.clear()

seen = []
odometry, twist = Odometry(), Twist()
odometry.pose.pose.position.x, twist.linear.x = 3.0, 0.5
odometry.pose.pose.orientation.w = 1.0
print(json.dumps([read(*each) for each in ((Odometry, odometry), (Twist, twist))]))
"""


def test_panel_and_trail_follow_a_topic_that_changes_its_type(master):
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={
            **os.environ,
            "ROS_MASTER_URI": master.uri,
            "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        },
        capture_output=True,
        text=True,
        timeout=60,
    )

    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout.splitlines()[-1]) == [
        ["3.00, 0.00 m, 0\N{DEGREE SIGN}", "Odometry"],
        ["0.50 m/s, 0.00 rad/s", "Twist"],
    ]

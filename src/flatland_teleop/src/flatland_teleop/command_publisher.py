"""Publishers of a robot's commands."""

import warnings

import rospy
from geometry_msgs.msg import Twist


def command_publisher(topic: str) -> rospy.Publisher:
    """A publisher that has sent a command when `publish` returns.

    With a queue, rospy hands it to a thread, which may not run before the topic is closed. The last
    command, which stops the robot, would be lost.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)  # that there is no queue
        return rospy.Publisher(topic, Twist, queue_size=None)

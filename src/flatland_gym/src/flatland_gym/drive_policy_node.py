"""The node that drives a robot to goals with a trained policy (docs/learning.md)."""

import sys

import rospy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from flatland_gym.policy import Policy
from flatland_gym.policy_node import PolicyNode
from flatland_server import FlatlandError


def main() -> int:
    """Runs the node until it is shut down. Returns its exit code."""
    rospy.init_node("drive_policy")
    try:
        node = PolicyNode(
            Policy.load(rospy.get_param("~policy", "discs")),
            rospy.Publisher("cmd_vel", Twist, queue_size=1),
            rospy.get_param("~goal_radius", 0.3),
            rospy.logerr,
        )
    except FlatlandError as error:
        rospy.logfatal("%s", error)
        return 1
    rospy.Subscriber("odometry/ground_truth", Odometry, node.on_odometry, queue_size=1)
    rospy.Subscriber("move_base_simple/goal", PoseStamped, node.on_goal, queue_size=1)
    rospy.Subscriber("scan", LaserScan, node.on_scan, queue_size=1)
    rospy.loginfo("ready for goals")
    rospy.spin()
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""The trained policy drives the robot to goals through its topics.

The columns stay where the world file has them; starts and goals are drawn between them.
`--goals 20` drives to more of them.
"""

import math
import random
import sys
import unittest

import rospy
import rostest
import service_calls
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from waiting import wait_until

GOALS = int(sys.argv[sys.argv.index("--goals") + 1]) if "--goals" in sys.argv else 5
COLUMNS = (
    *((-3.5, -3.5), (-3.4, 0.2), (-3.3, 3.4), (-1.7, -1.8), (-1.6, 1.7), (0.1, -3.6)),
    *((0.2, 3.5), (1.8, -1.6), (1.7, 1.8), (3.4, -3.4), (3.5, 0.1), (3.5, 3.5)),
)
LONGEST = 30.0  # s


class TestPolicy(unittest.TestCase):
    def setUp(self):
        self._odometry = None
        rospy.Subscriber("odometry/ground_truth", Odometry, self._note)
        self._goals = rospy.Publisher("move_base_simple/goal", PoseStamped, queue_size=1)
        wait_until(lambda: self._odometry and self._goals.get_num_connections(), "the robot", 20.0)

    def _note(self, message):
        self._odometry = message

    def _distance(self, goal):
        position = self._odometry.pose.pose.position
        return math.dist((position.x, position.y), goal)

    def _is_at_rest(self):
        return abs(self._odometry.twist.twist.linear.x) < 0.01

    def _drive(self, start, goal):
        """True if the robot gets to a goal in time."""
        service_calls.move("robot", *start, random.uniform(-math.pi, math.pi))
        wait_until(lambda: self._distance(start) < 0.1, "the move", 10.0)
        message = PoseStamped()
        message.pose.position.x, message.pose.position.y = goal
        message.pose.orientation.w = 1.0
        self._goals.publish(message)
        begin = rospy.get_time()
        wait_until(
            lambda: self._distance(goal) < 0.3 or rospy.get_time() - begin > LONGEST,
            "the goal",
            LONGEST,
        )
        return self._distance(goal) < 0.35

    def test_goals_are_reached(self):
        random.seed(1)
        reached = [self._drive(free_place(), free_place()) for _ in range(GOALS)]
        print(f"reached {sum(reached)} of {len(reached)}")
        self.assertGreaterEqual(sum(reached), 0.85 * len(reached) - 0.5)
        wait_until(self._is_at_rest, "the robot to stop", 10.0)


def free_place():
    """A place between the columns."""
    while True:
        place = random.uniform(-4.6, 4.6), random.uniform(-4.6, 4.6)
        if all(math.dist(place, column) > 0.35 + 0.2 + 0.1 for column in COLUMNS):
            return place


if __name__ == "__main__":
    rospy.init_node("policy_rostest")
    rostest.rosrun("flatland_gym", "policy", TestPolicy)

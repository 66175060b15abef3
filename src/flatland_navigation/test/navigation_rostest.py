#!/usr/bin/python3
"""Over a real master: goals by topic and by action, refusals, cancellation, pause, two robots."""

import math
import sys
import unittest

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from flatland_msgs.msg import SimulationState
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseActionResult, MoveBaseGoal
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock
from rostest_tools import Recorder
from service_calls import call
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage
from waiting import wait_until


def target(x, y, yaw, frame="map"):
    """A goal's pose."""
    pose = PoseStamped()
    pose.header.frame_id = frame
    pose.pose.position.x, pose.pose.position.y = x, y
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose


class Navigation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.client = actionlib.SimpleActionClient("move_base", MoveBaseAction)
        cls.results = Recorder("/r1/move_base/result", MoveBaseActionResult)
        cls.pose = Recorder("/odometry/ground_truth", Odometry)
        cls.client.wait_for_server()

    def drive(self, *pose, **options):
        """Sends a goal, and returns its final state and text."""
        self.client.send_goal(MoveBaseGoal(target(*pose, **options)))
        wait_until(lambda: self.client.simple_state == actionlib.SimpleGoalState.DONE, f"{pose}")
        return self.client.get_state(), self.client.get_goal_status_text()

    def position(self):
        position = self.pose.next().pose.pose.position
        return position.x, position.y

    def test_a_goal_of_the_action_is_reached(self):
        self.assertEqual(self.drive(2.0, 0.5, 1.57), (GoalStatus.SUCCEEDED, "the goal is reached"))
        self.assertLess(math.dist(self.position(), (2.0, 0.5)), 0.1)

    def test_rvizs_goal_is_reached_and_shows_its_path(self):
        results = Recorder("/move_base/result", MoveBaseActionResult)
        plans = Recorder("/move_base/plan", Path)
        shown = Recorder("/move_base/current_goal", PoseStamped)
        goals = rospy.Publisher("/move_base_simple/goal", PoseStamped, queue_size=1, latch=True)
        self.addCleanup(goals.unregister)

        goals.publish(target(1.0, -0.5, 3.14))

        self.assertEqual(results.next().status.status, GoalStatus.SUCCEEDED)
        self.assertLess(math.dist(self.position(), (1.0, -0.5)), 0.1)
        paths = [plan for plan in plans.messages if plan.poses]
        end = paths[-1].poses[-1].pose.position
        self.assertEqual((paths[-1].header.frame_id, end.x, end.y), ("map", 1.0, -0.5))
        self.assertEqual(shown.messages[-1].pose, target(1.0, -0.5, 3.14).pose)

    def test_goals_are_refused_with_a_reason(self):
        for pose, frame, reason in (
            ((90.0, 0.0, 0.0), "map", "outside of the map"),
            ((3.0, 6.0, 0.0), "map", "m from a wall"),
            ((1.0, 0.0, 0.0), "base_link", 'expected a goal in the frame "map"'),
            ((math.nan, 0.0, 0.0), "map", "expected finite numbers"),
        ):
            state, text = self.drive(*pose, frame=frame)
            self.assertEqual(state, GoalStatus.ABORTED)
            self.assertIn(reason, text)

    def test_a_canceled_goal_stops_the_robot(self):
        self.client.send_goal(MoveBaseGoal(target(-6.0, 0.0, 0.0)))
        self.pose.next(holds=lambda m: m.twist.twist.linear.x > 0.2)

        self.client.cancel_goal()

        self.pose.next(holds=lambda m: m.twist.twist.linear.x == 0.0)
        wait_until(lambda: self.client.simple_state == actionlib.SimpleGoalState.DONE, "the end")
        self.assertEqual(self.client.get_state(), GoalStatus.PREEMPTED)

    def test_a_pause_does_not_abort_a_goal(self):
        self.client.send_goal(MoveBaseGoal(target(3.0, 0.0, 0.0)))
        self.pose.next(holds=lambda m: m.twist.twist.linear.x > 0.2)
        call("/pause", Empty)
        state = Recorder("/flatland_server/state", SimulationState).next(holds=lambda s: s.paused)
        clock = Recorder("/clock", Clock)
        rospy.rostime.wallsleep(0.5)  # the pause
        stamps = {message.clock for message in clock.messages}
        call("/resume", Empty)

        wait_until(lambda: self.client.simple_state == actionlib.SimpleGoalState.DONE, "the goal")

        self.assertEqual({stamp for stamp in stamps if stamp > state.stamp}, set())
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED)

    def test_the_robot_in_the_namespace_reaches_its_waypoints(self):
        odometry = Recorder("/r1/odometry/ground_truth", Odometry)
        wait_until(
            lambda: (
                math.dist((lambda p: (p.x, p.y))(odometry.next().pose.pose.position), (-2.5, 0.0))
                < 0.1
            ),
            "the last waypoint",
        )
        self.assertNotIn(GoalStatus.ABORTED, [m.status.status for m in self.results.messages])

    def test_its_odometry_is_connected_with_the_map(self):
        transforms = Recorder("/tf_static", TFMessage)
        edges = wait_until(
            lambda: {
                (t.header.frame_id, t.child_frame_id)
                for message in list(transforms.messages)
                for t in message.transforms
                if t.child_frame_id == "r1_odom"
            },
            "map -> r1_odom",
        )
        self.assertEqual(edges, {("map", "r1_odom")})
        frames = Recorder("/r1/odometry/filtered", Odometry).next()
        self.assertEqual(
            (frames.header.frame_id, frames.child_frame_id), ("r1_odom", "r1_base_link")
        )


if __name__ == "__main__":
    import rostest

    rospy.init_node("navigation_rostest")
    rostest.rosrun("flatland_navigation", "navigation", "__main__", sys.argv)

#!/usr/bin/python3
"""A fleet over a real master: transforms by namespace, and stamps of real time."""

import sys
import time
from functools import partial
from pathlib import Path

import rosgraph
import rospy
from flatland_msgs.msg import ModelList, ModelStates, SimulationState
from flatland_msgs.srv import ChangeRate, Reset, Seek, Step
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rostest_tools import RecordingCase
from sensor_msgs.msg import Imu, LaserScan, NavSatFix
from service_calls import call, delete, spawn
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage
from waiting import wait_until

ROBOTS = {"/r1": "r1", "/r2": "r2", "": "alone"}
"""Names by the namespaces of topics."""
MOVING = {("odom", "base"), ("base", "laser")}
STATIC = {("base", "imu"), ("base", "gps"), ("map", "odom")}
TOLERANCE = 2.0
"""Real time that a message may take to this process on a busy machine [s]."""
ROBOT = Path(__file__).resolve().parent / "worlds" / "fleet_robot.model.yaml"


def published():
    publishers, _, _ = rosgraph.Master("/test").getSystemState()
    return {topic for topic, _ in publishers}


def frames(message):
    return {(each.header.frame_id, each.child_frame_id) for each in message.transforms}


class TransformsByNamespace(RecordingCase):
    @classmethod
    def setUpClass(cls):
        cls.moving = {ns: cls.record(f"{ns}/tf", TFMessage) for ns in ROBOTS}
        cls.static = {ns: cls.record(f"{ns}/tf_static", TFMessage) for ns in ROBOTS}

    def test_each_namespace_has_transforms_with_unprefixed_frames(self):
        for namespace in ROBOTS:
            with self.subTest(namespace):
                moving = self.moving[namespace]
                moving.next(holds=lambda each: ("base", "laser") in frames(each))
                self.assertEqual(set().union(*map(frames, list(moving.messages))), MOVING)
                static = self.static[namespace].messages
                wait_until(partial(len, static), "static transforms")
                self.assertEqual(frames(static[-1]), STATIC)

    def test_headers_have_frames_without_prefix(self):
        for namespace in ROBOTS:
            for topic, kind, frame in (
                ("scan", LaserScan, "laser"),
                ("imu/filtered", Imu, "imu"),
                ("gps/fix", NavSatFix, "gps"),
                ("odometry/filtered", Odometry, "odom"),
                ("odometry/ground_truth", Odometry, "map"),
            ):
                with self.subTest(f"{namespace}/{topic}"):
                    message = rospy.wait_for_message(f"{namespace}/{topic}", kind, 10.0)
                    self.assertEqual(message.header.frame_id, frame)
                    if kind is Odometry:
                        self.assertEqual(message.child_frame_id, "base")

    def test_the_window_is_told_which_bodies_are_not_on_tf(self):
        models = rospy.wait_for_message("/flatland_server/models", ModelList, 10.0).models

        self.assertEqual(
            {each.name: each.bodies[0].frame_id for each in models if each.name in ROBOTS.values()},
            {"r1": "", "r2": "", "alone": "base"},
        )

    def test_robots_that_come_and_go_bring_and_take_their_topics(self):
        self.assertTrue(spawn(ROBOT, "r3", "r3", -3.0).success)
        moving, static = self.record("/r3/tf", TFMessage), self.record("/r3/tf_static", TFMessage)

        self.assertLessEqual(frames(moving.next()), MOVING)
        wait_until(lambda: static.messages and frames(static.messages[-1]) == STATIC, "the mounts")
        self.assertTrue(delete("r3").success)
        wait_until(lambda: "/r3/tf" not in published(), "the topic to go")

    def test_a_reset_keeps_the_topics(self):
        call("/reset", Reset, False, False, 0)

        for namespace in ROBOTS:
            self.assertLessEqual(frames(self.moving[namespace].next()), MOVING)
            self.assertEqual(frames(self.static[namespace].messages[-1]), STATIC)


class StampsOfRealTime(RecordingCase):
    @classmethod
    def setUpClass(cls):
        cls.scan = cls.record("/r1/scan", LaserScan)

    def tearDown(self):
        call("/resume", Empty)

    def assert_is_present(self, stamp):
        self.assertAlmostEqual(stamp.to_sec(), time.time(), delta=TOLERANCE)

    def next_stamp(self):
        return self.scan.next().header.stamp

    def state(self):
        return rospy.wait_for_message("/flatland_server/state", SimulationState, 10.0)

    def test_clock_is_not_published_and_nodes_use_real_time(self):
        self.assertNotIn("/clock", published())
        self.assertFalse(rospy.get_param("/use_sim_time"))

    def test_all_messages_and_transforms_have_stamps_of_real_time(self):
        for topic, kind in (
            ("/r1/scan", LaserScan),
            ("/r1/imu/filtered", Imu),
            ("/r1/gps/fix", NavSatFix),
            ("/r1/odometry/filtered", Odometry),
            ("/r1/odometry/ground_truth", Odometry),
        ):
            with self.subTest(topic):
                message = rospy.wait_for_message(topic, kind, 10.0)
                self.assert_is_present(message.header.stamp)
        for topic in ("/tf", "/r1/tf"):
            with self.subTest(topic):
                message = rospy.wait_for_message(topic, TFMessage, 10.0)
                self.assert_is_present(message.transforms[0].header.stamp)
        models = rospy.wait_for_message("/flatland_server/model_states", ModelStates, 10.0)
        self.assert_is_present(models.stamp)

    def test_a_pause_is_a_jump_of_stamps_alone(self):
        call("/pause", Empty)
        wait_until(lambda: self.state().paused, "the pause")  # the topic follows the service
        before = self.state().stamp.to_sec()
        last = self.scan.messages[-1].header.stamp if self.scan.messages else rospy.Time(0)
        rospy.rostime.wallsleep(TOLERANCE + 1.0)  # the pause itself
        self.assertEqual(self.state().stamp.to_sec(), before)

        call("/resume", Empty)

        stamp = self.next_stamp()
        self.assert_is_present(stamp)
        self.assertGreater(stamp, last)
        self.assertLess(self.state().stamp.to_sec() - before, TOLERANCE)

    def test_steps_and_resets_never_turn_stamps_back(self):
        call("/pause", Empty)
        first = call("/step", Step, 100, [], 0.0).time
        self.assert_is_present(first)
        self.assertTrue(call("/seek", Seek, self.state().history_begin.to_sec()).success)
        begin = self.state().stamp
        second = call("/step", Step, 100, [], 0.0).time
        call("/reset", Reset, True, False, 0)
        wait_until(lambda: self.state().stamp.to_sec() == 0.0, "simulated time to begin again")
        third = call("/step", Step, 100, [], 0.0).time

        self.assertLess(begin.to_sec(), 1e6)
        self.assertGreaterEqual((second - first).to_sec(), 0.5)
        self.assertGreaterEqual((third - second).to_sec(), 0.5)
        stamps = [each.header.stamp for each in list(self.scan.messages)]
        self.assertEqual(stamps, sorted(stamps))

    def test_a_rate_other_than_1_is_refused(self):
        answer = call("/change_rate", ChangeRate, 2.0)

        self.assertFalse(answer.success)
        self.assertRegex(answer.message, "^UsageError: expected a rate of 1, since messages are")
        self.assertEqual(self.state().rate, 1.0)

    def test_robots_drive(self):
        truth = self.record("/r2/odometry/ground_truth", Odometry)
        command = rospy.Publisher("/r2/cmd_vel", Twist, queue_size=1)
        wait_until(command.get_num_connections, "the drive to subscribe")
        message = Twist()
        message.linear.x = 0.5
        command.publish(message)
        self.addCleanup(command.publish, Twist())

        truth.next(holds=lambda each: each.twist.twist.linear.x > 0.4)


if __name__ == "__main__":
    import rostest

    rospy.init_node("fleet_rostest")
    rostest.rosrun("flatland_server", "fleet", "__main__", sys.argv)

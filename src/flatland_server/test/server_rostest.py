"""The server in an empty room of 10 x 6 m, over a real master."""

import math

import rospy
import tf2_ros
from flatland_msgs.srv import Reset
from geometry_msgs.msg import Twist, TwistWithCovarianceStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from rostest_tools import RecordingCase, period, publish_rate
from sensor_msgs.msg import LaserScan
from service_calls import call
from tf2_msgs.msg import TFMessage
from waiting import wait_until


def yaw_of(quaternion):
    return 2.0 * math.atan2(quaternion.z, quaternion.w)


def range_in_room(x, y, angle):
    """Distance from a point within |x| <= 5, |y| <= 3 to the walls."""
    cos, sin = math.cos(angle), math.sin(angle)
    to_x = (math.copysign(5.0, cos) - x) / cos if cos else math.inf
    to_y = (math.copysign(3.0, sin) - y) / sin if sin else math.inf
    return min(to_x, to_y)


class Server(RecordingCase):
    @classmethod
    def setUpClass(cls):
        answer = call("/reset", Reset, True, False, 0)  # other tests may have moved the robot
        assert answer.success, answer.message
        cls.clock = cls.record("/clock", Clock)
        cls.tf = cls.record("/tf", TFMessage)
        cls.scan = cls.record("/scan", LaserScan)
        cls.truth = cls.record("/odometry/ground_truth", Odometry)
        cls.odometry = cls.record("/odometry/filtered", Odometry)
        cls.twist = cls.record("/twist", TwistWithCovarianceStamped)
        cls.cmd_vel = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
        wait_until(cls.cmd_vel.get_num_connections, "the server to subscribe to /cmd_vel")
        cls.clock.next()

    def command(self, forwards, turn):
        twist = Twist()
        twist.linear.x, twist.angular.z = forwards, turn
        self.cmd_vel.publish(twist)

    def test_clock_odometry_and_tf_follow_an_arc_at_each_step(self):
        self.clock.next()
        begin = len(self.clock.messages)
        self.check_arc()
        self.clock.next()

        steps = [
            (b.clock - a.clock).to_nsec()
            for a, b in zip(self.clock.messages[begin:], self.clock.messages[begin + 1 :])
        ]
        self.assertEqual({step % 5_000_000 for step in steps}, {0})
        self.assertIn(5_000_000, steps)  # a late server may make several before it publishes

    def check_arc(self):
        """Drives along an arc for two seconds."""
        self.command(0.5, 0.2)
        start = self.truth.next(holds=lambda m: m.twist.twist.linear.x > 0.4)
        arrival = start.header.stamp + rospy.Duration(2.0)
        end = self.truth.next(holds=lambda m: m.header.stamp >= arrival)
        pose = self.find_transform("base_link", end.header.stamp)
        self.command(0.0, 0.0)

        yaw = yaw_of(end.pose.pose.orientation)
        x, y = end.pose.pose.position.x, end.pose.pose.position.y
        self.assertAlmostEqual(x, 2.5 * math.sin(yaw), delta=0.005)
        self.assertAlmostEqual(y, 2.5 * (1.0 - math.cos(yaw)), delta=0.005)
        elapsed = (end.header.stamp - start.header.stamp).to_sec()
        turned = yaw - yaw_of(start.pose.pose.orientation)
        self.assertAlmostEqual(turned, 0.2 * elapsed, delta=0.001)
        self.assertAlmostEqual(end.twist.twist.linear.x, 0.5, delta=1e-3)
        self.assertAlmostEqual(end.twist.twist.linear.y, 0.0, delta=1e-3)
        self.assertAlmostEqual(end.twist.twist.angular.z, 0.2, delta=1e-3)
        self.assertEqual((end.header.frame_id, end.child_frame_id), ("map", "base_link"))

        self.assertEqual(pose.header.frame_id, "odom")
        self.assertAlmostEqual(pose.transform.translation.x, x, delta=1e-9)
        self.assertAlmostEqual(pose.transform.translation.y, y, delta=1e-9)
        self.assertAlmostEqual(yaw_of(pose.transform.rotation), yaw, delta=1e-9)

    def find_transform(self, child, stamp):
        def found():
            return [
                t
                for message in self.tf.messages
                for t in message.transforms
                if t.child_frame_id == child and t.header.stamp == stamp
            ]

        return wait_until(found, f"the transform of {child} at {stamp.to_sec()}")[0]

    def test_every_range_is_that_of_the_room(self):
        scan = self.scan.next(2)
        pose = self.find_transform("base_link", scan.header.stamp).transform
        mount = self.find_transform("laser", scan.header.stamp).transform.translation

        yaw = yaw_of(pose.rotation)
        x = pose.translation.x + math.cos(yaw) * mount.x
        y = pose.translation.y + math.sin(yaw) * mount.x
        self.assertEqual(len(scan.ranges), 1081)
        for beam, distance in enumerate(scan.ranges):
            angle = yaw - 2.356194490192345 + beam * 0.004363323129985824
            self.assertAlmostEqual(distance, range_in_room(x, y, angle), delta=0.001)
        self.assertEqual(scan.header.frame_id, "laser")
        self.assertEqual((scan.range_min, scan.range_max), (0.0, 20.0))

    def test_stamps_are_those_of_the_clock(self):
        self.scan.next(12)
        ticks = {m.clock.to_nsec() for m in list(self.clock.messages)}
        newest = max(ticks)
        stamps = {
            m.header.stamp.to_nsec()
            for recorder in (self.scan, self.truth, self.odometry, self.twist)
            for m in list(recorder.messages)[2:]
        }
        stamps |= {t.header.stamp.to_nsec() for m in self.tf.messages[2:] for t in m.transforms}
        stamps = {stamp for stamp in stamps if min(ticks) <= stamp <= newest}
        self.assertGreater(len(stamps), 50)
        # Equal sets if no tick was lost, as on a busy machine.
        self.assertEqual(period(ticks), 5_000_000)
        self.assertEqual(period(ticks | stamps), 5_000_000)

    def test_topics_come_at_their_rates(self):
        self.assertEqual(publish_rate(self.scan, 6), 10.0)
        self.assertEqual(publish_rate(self.odometry, 20), 50.0)
        self.assertEqual(publish_rate(self.twist, 20), 50.0)

    def test_each_frame_has_one_parent(self):
        self.scan.next(5)
        parents = {}
        for message in self.tf.messages:
            for transform in message.transforms:
                parents.setdefault(transform.child_frame_id, set()).add(transform.header.frame_id)

        self.assertEqual(
            parents,
            {
                "base_link": {"odom"},
                "laser": {"base_link"},
                "left_wheel": {"base_link"},
                "right_wheel": {"base_link"},
            },
        )

    def test_transforms_of_one_step_are_one_message(self):
        self.scan.next(5)
        stamps = [m.transforms[0].header.stamp for m in self.tf.messages]
        self.assertEqual(len(stamps), len(set(stamps)))

    def test_tf2_finds_the_laser_in_odom(self):
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        found = wait_until(
            lambda: buffer.can_transform("odom", "laser", rospy.Time(0)), "odom -> laser"
        )
        self.assertTrue(found)

    def test_a_command_that_is_not_a_number_is_ignored(self):
        # Independent of other tests: the robot must only keep running.
        self.command(math.nan, 0.0)
        self.command(0.0, math.inf)
        before = self.truth.next()
        after = self.truth.next(20)
        self.assertTrue(math.isfinite(after.pose.pose.position.x))
        self.assertGreater(after.header.stamp, before.header.stamp)

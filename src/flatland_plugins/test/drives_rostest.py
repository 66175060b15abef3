"""Over a real master: the drives, Tween, Pedestrian, ModelTfPublisher and PosePublisher."""

import math

import rospy
import rostest_case
from geometry_msgs.msg import PoseStamped, Quaternion, TwistWithCovarianceStamped
from nav_msgs.msg import Odometry
from readings import pose_of, turned
from robots import Frame, Topic
from std_msgs.msg import Bool
from waiting import wait_until


class Driving:
    """With `PluginCase`: both bodies of both robots are driven all the time."""

    subscribed = ("cmd_vel", "second/cmd_vel")
    command = second_command = (0.0, 0.0, 0.0)  # forwards [m/s], to the left [m/s], turn [rad/s]
    velocities = ()  # topics of odometry, and the velocities that the commands lead to

    @classmethod
    def get_going(cls):
        for robot in cls.robots:
            cls.drive(robot.topic("cmd_vel"), *cls.command)
            cls.drive(robot.topic("second/cmd_vel"), *cls.second_command)

    def test_odometry_has_the_commanded_velocities(self):
        for robot in self.robots:
            for name, expected in self.velocities:
                twist = self.recorder_of(robot, name).next().twist.twist
                found = twist.linear.x, twist.linear.y, twist.angular.z
                for value, number in zip(found, expected):
                    self.assertAlmostEqual(value, number, delta=1e-3, msg=f"{name}: {found}")

    def assert_odometry_and_tf_agree(self, topic, frame):
        """Fails if a body's odometry is not the transform of the same time."""
        for robot in self.robots:
            odometry = self.recorder_of(robot, topic).next()
            transform = self.transform(robot, frame, odometry.header.stamp)
            self.assert_pose(pose_of(transform), pose_of(odometry.pose.pose), delta=1e-9)


class DiffDrive(Driving, rostest_case.PluginCase):
    model = "diff_drive"
    published = (
        Topic("odometry/filtered", Odometry, 200.0, "odom", "{ns}base_link"),
        Topic("odometry/ground_truth", Odometry, 200.0, "map", "{ns}base_link"),
        Topic("twist", TwistWithCovarianceStamped, 200.0, "{ns}base_link"),
        Topic("second/odometry", Odometry, 25.0, "second_odom", "{ns}second"),
        Topic("second/truth", Odometry, 25.0, "world", "{ns}second"),
        Topic("second/twist", TwistWithCovarianceStamped, 25.0, "{ns}second"),
    )
    frames = (Frame("odom", "{ns}base_link"),)
    command = (0.4, 0.0, 0.8)
    second_command = (-0.3, 5.0, 0.5)  # it cannot go to the left
    velocities = (("odometry/ground_truth", command),)

    def test_odometry_and_tf_agree(self):
        self.assert_odometry_and_tf_agree("odometry/filtered", "{ns}base_link")


class OmniDrive(Driving, rostest_case.PluginCase):
    model = "omni_drive"
    published = (
        Topic("odometry/filtered", Odometry, 200.0, "odom", "{ns}base_link"),
        Topic("odometry/ground_truth", Odometry, 200.0, "map", "{ns}base_link"),
        Topic("twist", TwistWithCovarianceStamped, 200.0, "{ns}base_link"),
        Topic("second/odometry", Odometry, 25.0, "second_odom", "{ns}second"),
        Topic("second/truth", Odometry, 25.0, "world", "{ns}second"),
    )
    frames = (Frame("odom", "{ns}base_link"), Frame("second_odom", "{ns}second", 25.0))
    command = (0.0, 0.05, 0.0)
    second_command = (0.3, 0.2, 0.5)
    velocities = (("odometry/ground_truth", command), ("second/truth", second_command))

    def test_odometry_and_tf_agree(self):
        self.assert_odometry_and_tf_agree("odometry/filtered", "{ns}base_link")
        self.assert_odometry_and_tf_agree("second/odometry", "{ns}second")


class TricycleDrive(Driving, rostest_case.PluginCase):
    model = "tricycle_drive"
    published = (
        Topic("odometry/filtered", Odometry, 200.0, "odom", "{ns}base_link"),
        Topic("odometry/ground_truth", Odometry, 200.0, "map", "{ns}base_link"),
        Topic("second/odometry", Odometry, 25.0, "second_odom", "{ns}base_2"),
        Topic("second/truth", Odometry, 25.0, "world", "{ns}base_2"),
        Topic("second/twist", TwistWithCovarianceStamped, 25.0, "{ns}base_2"),
    )
    frames = (Frame("odom", "{ns}base_link"),)
    command = (0.4, 0.0, 0.6)  # of the front wheel: its speed and its angle
    second_command = (-0.3, 0.0, -0.3)
    # The front wheel moves where it points, and the rear axle is 0.5 m behind it.
    velocities = tuple(
        (name, (v * math.cos(a), v * math.sin(a), v * math.sin(a) / 0.5))
        for name, v, a in (("odometry/ground_truth", 0.4, 0.6), ("second/truth", -0.3, -0.3))
    )

    def test_odometry_and_tf_agree(self):
        self.assert_odometry_and_tf_agree("odometry/filtered", "{ns}base_link")


class ModelTfPublisher(rostest_case.PluginCase):
    model = "model_tf_publisher"
    frames = (
        Frame("{ns}base", "{ns}arm"),
        Frame("world", "{ns}mast", 25.0),
        Frame("{ns}mast", "{ns}flag", 25.0),
    )


class Tween(rostest_case.PluginCase):
    model = "tween"
    subscribed = ("tween_trigger", "second_gate/open")
    frames = (
        Frame("{ns}base", "{ns}lift"),
        Frame("{ns}base", "{ns}gate"),
        Frame("{ns}base", "{ns}second_gate"),
    )

    def expected(self, robot, start, delta):
        """A body's pose on the base, when it has gone by a delta of the world's frame."""
        x, y = turned(delta[:2], -robot.yaw)
        return start[0] + x, start[1] + y, start[2] + delta[2]

    def test_gates_open_and_close_when_commanded(self):
        gates = [
            (robot, *gate)
            for robot in self.robots
            for gate in (
                ("tween_trigger", "{ns}gate", 1.0),
                ("second_gate/open", "{ns}second_gate", 2.0),
            )
        ]
        self.turn_gates(gates, True)
        self.turn_gates(gates, False)

    def gate(self, robot, x, part):
        """A gate's pose on the base when it is open by a part."""
        return self.expected(robot, (x, 0.0, 0.0), (0.0, 0.4 * part, 1.0 * part))

    def turn_gates(self, gates, is_open):
        """Commands gates, and waits until all have turned."""
        for robot, topic, _, _ in gates:
            publisher = rospy.Publisher(robot.topic(topic), Bool, queue_size=1, latch=True)
            self.addCleanup(publisher.unregister)
            publisher.publish(is_open)

        def have_turned():
            stamp = self.tf.next().transforms[0].header.stamp
            poses = [
                (pose_of(self.transform(robot, frame, stamp)), self.gate(robot, x, is_open))
                for robot, _, frame, x in gates
            ]
            return all(math.dist(pose, end) < 1e-6 for pose, end in poses)

        wait_until(have_turned, "the gates to turn")


class Pedestrian(rostest_case.PluginCase):
    """With PosePublisher, also by its other name."""

    model = "pedestrian"
    published = (
        Topic("pose", PoseStamped, 10.0, "map"),
        Topic("leg/pose", PoseStamped, 25.0, "world"),
    )
    subscribed = ("agent",)

    def test_pedestrians_go_where_odometry_says(self):
        for robot in self.robots:
            goal = (robot.x + 2.0, robot.y - 0.4)
            odometry = Odometry()
            odometry.pose.pose.position.x, odometry.pose.pose.position.y = goal
            odometry.pose.pose.orientation = Quaternion(0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
            odometry.twist.twist.linear.x = 0.3  # to the north, for a second
            publisher = rospy.Publisher(robot.topic("agent"), Odometry, queue_size=1, latch=True)
            self.addCleanup(publisher.unregister)
            publisher.publish(odometry)
            end = (goal[0], goal[1] + 0.3, math.pi / 2)
            left_leg = turned((0.0, 0.15), end[2], end[:2])

            def has_arrived(robot=robot, end=end, left_leg=left_leg):
                pose = pose_of(self.recorder_of(robot, "pose").next().pose)
                leg = pose_of(self.recorder_of(robot, "leg/pose").next().pose)
                return math.dist(pose, end) < 1e-3 and math.dist(leg[:2], left_leg) < 0.02

            wait_until(has_arrived, "the pedestrian to arrive")

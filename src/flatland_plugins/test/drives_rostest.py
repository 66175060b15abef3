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


def odometry(name, truth, rate, frame, truth_frame, child):
    """The topics of odometry of a body."""
    return (
        Topic(name, Odometry, rate, frame, child),
        Topic(truth, Odometry, rate, truth_frame, child),
    )


FILTERED, TRUTH = "odometry/filtered", "odometry/ground_truth"
FIRST = odometry(FILTERED, TRUTH, 200.0, "odom", "map", "{ns}base_link")
SECOND = ("second/odometry", "second/truth", 25.0, "second_odom", "world")
TWIST = Topic("twist", TwistWithCovarianceStamped, 200.0, "{ns}base_link")


class Driving:
    """With `PluginCase`: both bodies of both robots are driven all the time."""

    subscribed = ("cmd_vel", "second/cmd_vel")
    command = second_command = (0.0, 0.0, 0.0)  # forwards [m/s], to the left [m/s], turn [rad/s]
    velocities = ()  # topics of odometry, and the velocities that the commands lead to
    odometry_frames = (("odometry/filtered", "{ns}base_link"),)  # of the same poses
    frames = (Frame("odom", "{ns}base_link"),)

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

    def test_odometry_and_tf_agree(self):
        for robot in self.robots:
            for topic, frame in self.odometry_frames:
                odometry = self.recorder_of(robot, topic).next()
                transform = self.transform(robot, frame, odometry.header.stamp)
                self.assert_pose(pose_of(transform), pose_of(odometry.pose.pose), delta=1e-9)


class DiffDrive(Driving, rostest_case.PluginCase):
    model = "diff_drive"
    published = (
        *FIRST,
        TWIST,
        *odometry(*SECOND, "{ns}second"),
        Topic("second/twist", TwistWithCovarianceStamped, 25.0, "{ns}second"),
    )
    command = (0.4, 0.0, 0.8)
    second_command = (-0.3, 5.0, 0.5)  # it cannot go to the left
    velocities = (("odometry/ground_truth", command),)


class OmniDrive(Driving, rostest_case.PluginCase):
    model = "omni_drive"
    published = (*FIRST, TWIST, *odometry(*SECOND, "{ns}second"))
    frames = (*Driving.frames, Frame("second_odom", "{ns}second", 25.0))
    odometry_frames = (*Driving.odometry_frames, ("second/odometry", "{ns}second"))
    command = (0.0, 0.05, 0.0)
    second_command = (0.3, 0.2, 0.5)
    velocities = (("odometry/ground_truth", command), ("second/truth", second_command))


class TricycleDrive(Driving, rostest_case.PluginCase):
    model = "tricycle_drive"
    published = (
        *FIRST,
        *odometry(*SECOND, "{ns}base_2"),
        Topic("second/twist", TwistWithCovarianceStamped, 25.0, "{ns}base_2"),
    )
    command = (0.4, 0.0, 0.6)  # of the front wheel: its speed and its angle
    second_command = (-0.3, 0.0, -0.3)
    # The front wheel moves where it points, and the rear axle is 0.5 m behind it.
    velocities = tuple(
        (name, (v * math.cos(a), v * math.sin(a), v * math.sin(a) / 0.5))
        for name, v, a in (("odometry/ground_truth", 0.4, 0.6), ("second/truth", -0.3, -0.3))
    )


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

    def test_gates_open_and_close_when_commanded(self):
        first = ("tween_trigger", "{ns}gate", 1.0)
        second = ("second_gate/open", "{ns}second_gate", 2.0)
        gates = [(robot, *gate) for robot in self.robots for gate in (first, second)]
        self.turn_gates(gates, True)
        self.turn_gates(gates, False)

    def gate(self, robot, x, part):
        """A gate's pose on the base when it is open by a part, to the north of the world."""
        return (*turned((0.0, 0.4 * part), -robot.yaw, (x, 0.0)), 1.0 * part)

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

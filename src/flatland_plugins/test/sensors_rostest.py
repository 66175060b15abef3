"""Over a real master: the sensors."""

import math

import rostest_case
from flatland_msgs.msg import Collisions
from nav_msgs.msg import Odometry
from robots import Frame, Robot, Topic
from rostest_case import WORLDS
from sensor_msgs.msg import Imu as ImuMessage
from sensor_msgs.msg import LaserScan, NavSatFix
from service_calls import delete, move, spawn
from std_msgs.msg import Bool
from waiting import wait_until

FACING_THE_WALL = (Robot("plain", "", 4.5, 1.2, 0.0), Robot("spaced", "ns", 4.5, -1.2, 0.0))


def range_in_room(x, y, angle):
    """Distance from a point within |x| <= 5, |y| <= 3 to the walls."""
    cos, sin = math.cos(angle), math.sin(angle)
    return min((math.copysign(5.0, cos) - x) / cos, (math.copysign(3.0, sin) - y) / sin)


class Bumper(rostest_case.PluginCase):
    model = "bumper"
    published = (
        Topic("collisions", Collisions, 200.0, "map"),
        Topic("slow/collisions", Collisions, 25.0, "world"),
    )
    subscribed = ("cmd_vel",)
    robots = FACING_THE_WALL

    def test_a_robot_is_told_of_the_wall_that_it_presses_against(self):
        recorders = {
            name: (robot, self.recorder_of(robot, name))
            for robot in self.robots
            for name in ("collisions", "slow/collisions")
        }
        for _, recorder in recorders.values():
            self.assertEqual(recorder.next().collisions, [])
        for robot in self.robots:
            self.drive(robot.topic("cmd_vel"), x=0.3)
        for robot, recorder in recorders.values():
            recorder.next(5, holds=lambda m: m.collisions)  # after the impact
            (collision,) = recorder.next().collisions
            reported = (collision.entity_A, collision.body_A, collision.entity_B)
            self.assertEqual(reported, (robot.name, "base", "room"))
            self.assertAlmostEqual(collision.contact_positions[0].x, 5.0, delta=0.02)

        for robot in self.robots:
            self.drive(robot.topic("cmd_vel"), x=-0.3)
        for _, recorder in recorders.values():
            wait_until(lambda r=recorder: not r.next().collisions, "the robot to be free")


class BoolSensor(rostest_case.PluginCase):
    model = "bool_sensor"
    published = (Topic("bool_sensor", Bool), Topic("pad/pressed", Bool, 20.0))

    def test_each_sensor_tells_of_what_is_on_it_alone(self):
        answer = spawn(WORLDS / "visitor.model.yaml", "visitor", "", 3.0, 2.5)
        self.assertTrue(answer.success, answer.message)
        self.addCleanup(delete, "visitor")
        places = {
            robot.topic(name): robot.at(x, 0.0)
            for robot in self.robots
            for name, x in (("bool_sensor", 0.0), ("pad/pressed", 1.0))
        }
        for pressed, place in [("none", (3.0, 2.5)), *places.items(), ("none", (3.0, 2.5))]:
            self.assertTrue(move("visitor", *place).success)
            expected = {topic: topic == pressed for topic in places}
            wait_until(
                lambda e=expected: e == {t: self.recorders[t].next().data for t in places},
                f"{pressed} to be pressed",
            )


class Gps(rostest_case.PluginCase):
    model = "gps"
    published = (
        Topic("gps/fix", NavSatFix, 10.0, "{ns}receiver"),
        Topic("second/fix", NavSatFix, 25.0, "{ns}antenna"),
    )
    frames = (Frame("{ns}base", "{ns}receiver", 10.0), Frame("{ns}base", "{ns}antenna", 25.0))


class Imu(rostest_case.PluginCase):
    model = "imu"
    published = (
        Topic("odometry/filtered", Odometry),
        Topic("odometry/ground_truth", Odometry),
        Topic("imu/filtered", ImuMessage, 200.0, "{ns}imu"),
        Topic("imu/ground_truth", ImuMessage, 200.0, "{ns}imu"),
        Topic("second/imu", ImuMessage, 25.0, "{ns}second_imu"),
        Topic("second/truth", ImuMessage, 25.0, "{ns}second_imu"),
    )
    subscribed = ("cmd_vel",)
    frames = (Frame("{ns}base", "{ns}imu"), Frame("{ns}base", "{ns}second_imu", 25.0))

    @classmethod
    def get_going(cls):
        for robot in cls.robots:
            cls.drive(robot.topic("cmd_vel"), x=0.6, turn=1.2)

    def test_on_a_circle_the_acceleration_is_inwards(self):
        for robot in self.robots:
            for name in ("imu/filtered", "imu/ground_truth", "second/truth"):
                imu = self.recorder_of(robot, name).next(3)
                self.assertAlmostEqual(imu.angular_velocity.z, 1.2, delta=1e-4)
                acceleration = imu.linear_acceleration
                self.assertAlmostEqual(acceleration.x, 0.0, delta=2e-3)
                self.assertAlmostEqual(acceleration.y, 0.6**2 / 0.5, delta=2e-3)  # v^2 / r
                self.assertAlmostEqual(acceleration.z, 9.80665, delta=1e-9)


class Laser(rostest_case.PluginCase):
    model = "laser"
    published = (
        Topic("scan", LaserScan, 200.0, "{ns}laser"),
        Topic("rear/scan", LaserScan, 25.0, "{ns}rear_link"),
    )
    frames = (Frame("{ns}base", "{ns}laser"), Frame("{ns}base", "{ns}rear_link", 25.0))

    def test_ranges_are_those_of_the_room(self):
        for robot in self.robots:
            for name, origin, angle, range_max in (
                ("scan", (0.0, 0.0), 0.0, 20.0),
                ("rear/scan", (-0.1, 0.0), math.pi, 15.0),
            ):
                scan = self.recorder_of(robot, name).next()
                self.assertEqual((scan.range_min, scan.range_max), (0.0, range_max))
                self.assertEqual(len(scan.ranges), 3)
                for beam, distance in enumerate(scan.ranges):
                    heading = robot.yaw + angle + (beam - 1) * math.pi / 2
                    expected = range_in_room(*robot.at(*origin), heading)
                    self.assertAlmostEqual(distance, expected, delta=1e-4)

"""The services over a real master: two robots in namespaces, invalid requests, slow files."""

import math
import threading
from pathlib import Path

import rospkg
import rospy
import tcpros_client
from flatland_msgs.msg import DebugTopicList
from flatland_msgs.srv import ChangeRate, GetModelMarkers, SpawnModel, SpawnModelRequest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from rostest_tools import Recorder, RecordingCase
from sensor_msgs.msg import LaserScan
from service_calls import ServerTopics, call, delete, move, spawn
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray
from waiting import wait_until

OFFICE = Path(rospkg.RosPack().get_path("flatland_server")) / "worlds" / "office"
TURTLEBOT = str(OFFICE / "turtlebot.model.yaml")
BOX = str(OFFICE / "box.model.yaml")
SLOW_MODEL = Path(__file__).resolve().parent / "worlds" / "slow_to_read.model.yaml"


GUARD = """
bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1, layers: []}]}]
plugins:
  - {type: Gps, name: gps, body: base, static_tf: true}
  - {type: Imu, name: imu, body: base, static_tf: true}
"""


MODEL, YAML = "ModelError", "YamlError"
"""Beginnings of error messages."""


def change_rate(rate):
    return call("/change_rate", ChangeRate, rate)


def model_markers(path):
    return call("/get_model_markers", GetModelMarkers, path)


def x_of(markers):
    """The x coordinate of the first of a model's markers."""
    return markers.markers[0].pose.position.x


class Services(RecordingCase):
    @classmethod
    def setUpClass(cls):
        cls.clock = cls.record("/clock", Clock)
        cls.tf = cls.record("/tf", TFMessage)
        cls.static = cls.record("/tf_static", TFMessage)
        cls.clock.next()

    def frames(self):
        """Parents by frame, of the transforms from now on.

        Others may be on their way, so what counts are the stamps of the later half of 200 steps.
        """
        self.clock.next(200)
        begin = self.clock.messages[-100].clock
        return {
            t.child_frame_id: t.header.frame_id
            for message in self.tf.messages
            for t in message.transforms
            if t.header.stamp > begin
        }

    def static_edges(self):
        """Parent and child of all static transforms; a later subscriber gets the last message."""
        transforms = self.static.messages[-1].transforms if self.static.messages else []
        return {(t.header.frame_id, t.child_frame_id) for t in transforms}

    def test_two_robots_drive_and_scan_in_their_namespaces(self):
        before = ServerTopics.ask()
        robots = {"r1": 1.5, "r2": -1.5}
        recorders = {}
        for name, y in robots.items():
            answer = spawn(TURTLEBOT, name, name, -2.0, y)
            self.assertTrue(answer.success, answer.message)
            cmd_vel = rospy.Publisher(f"/{name}/cmd_vel", Twist, queue_size=1, latch=True)
            twist = Twist()
            twist.linear.x = 0.3 if name == "r1" else -0.3
            cmd_vel.publish(twist)
            recorders[name] = (
                Recorder(f"/{name}/odometry/ground_truth", Odometry),
                Recorder(f"/{name}/scan", LaserScan),
                cmd_vel,
            )

        for name, direction in (("r1", 1.0), ("r2", -1.0)):
            odometry, scan, _ = recorders[name]
            moved = odometry.next(
                holds=lambda m, d=direction: d * (m.pose.pose.position.x + 2.0) > 0.1
            )
            self.assertAlmostEqual(moved.pose.pose.position.y, robots[name], delta=1e-3)
            self.assertEqual(moved.child_frame_id, f"{name}_base_link")
            self.assertEqual(moved.header.frame_id, "map")
            self.assertEqual(scan.next().header.frame_id, f"{name}_laser")
        frames = self.frames()
        for name in robots:
            self.assertEqual(frames[f"{name}_base_link"], f"{name}_odom")
            self.assertEqual(frames[f"{name}_laser"], f"{name}_base_link")
            self.assertEqual(frames[f"{name}_left_wheel"], f"{name}_base_link")
        wait_until(
            lambda: (
                {("map", "odom"), ("map", "r1_odom"), ("map", "r2_odom")} <= self.static_edges()
            ),
            "the frames of odometry on the map",
        )

        for name in robots:
            for recorder in recorders[name][:2]:
                recorder.close()
            recorders[name][2].unregister()
            self.assertTrue(delete(name).success)
        wait_until(lambda: ServerTopics.ask() == before, "the topics of deleted robots to go")
        self.assertFalse([frame for frame in self.frames() if frame.startswith(("r1", "r2"))])

    def test_a_later_subscriber_gets_all_static_transforms(self):
        request = SpawnModelRequest(yaml_path=GUARD, name="guard", ns="guard")
        self.assertTrue(call("/spawn_model_from_string", SpawnModel, request).success)
        mounts = {("guard_base", "guard_gps"), ("guard_base", "guard_imu")}
        wait_until(lambda: mounts <= self.static_edges(), "the mounts")

        later = Recorder("/tf_static", TFMessage)
        first = wait_until(lambda: later.messages, "the latched message")[0]
        later.close()

        edges = {(t.header.frame_id, t.child_frame_id) for t in first.transforms}
        self.assertLessEqual({("map", "odom")} | mounts, edges)
        self.assertTrue(delete("guard").success)
        wait_until(lambda: not mounts & self.static_edges(), "the mounts to go")

    def test_a_model_within_another_one_is_spawned_with_a_warning(self):
        self.assertEqual(spawn(BOX, "alone", "", 3.0, -1.0).message, "")
        answer = spawn(BOX, "within", "", 3.1, -1.0)

        self.assertTrue(answer.success)
        self.assertEqual(
            answer.message, 'the model "within" overlaps the model "alone", and is pushed out'
        )
        for name in ("alone", "within"):
            delete(name)

    def test_a_moved_robot_is_there_and_at_rest(self):
        odometry = Recorder("/mover/odometry/ground_truth", Odometry)
        self.assertTrue(spawn(TURTLEBOT, "mover", "mover", 2.0, 2.0).success)
        cmd_vel = rospy.Publisher("/mover/cmd_vel", Twist, queue_size=1, latch=True)
        twist = Twist()
        twist.linear.x = 0.2
        cmd_vel.publish(twist)
        odometry.next(holds=lambda m: m.twist.twist.linear.x > 0.1)

        answer = move("mover", -3.0, -2.0, math.pi / 2)

        self.assertTrue(answer.success, answer.message)
        there = odometry.next(5)
        self.assertAlmostEqual(there.pose.pose.position.x, -3.0, delta=1e-5)
        self.assertAlmostEqual(there.pose.pose.position.y, -2.0, delta=1e-5)
        self.assertAlmostEqual(there.pose.pose.orientation.z, math.sin(math.pi / 4), delta=1e-5)
        self.assertAlmostEqual(there.twist.twist.linear.x, 0.0, delta=1e-4)
        cmd_vel.unregister()
        odometry.close()
        self.assertTrue(delete("mover").success)

    def test_invalid_requests_are_refused_and_change_nothing(self):
        before = ServerTopics.ask()
        for answer, error, expected in (
            (spawn("/nowhere/robot.yaml", "a"), MODEL, "there is no file /nowhere/robot.yaml"),
            (spawn(str(OFFICE), "a"), MODEL, f"there is no file {OFFICE}"),
            (spawn("bodies:\n- name: base", "a"), MODEL, "found a text: /spawn_model_from_string"),
            (spawn("", "a"), MODEL, "expected the path of a model file, found an empty string"),
            (spawn(str(OFFICE / "office.png"), "a"), YAML, "is not UTF-8 text"),
            (spawn(str(OFFICE / "office.yaml"), "a"), YAML, '"bodies" is missing'),
            (spawn(BOX, "turtlebot"), MODEL, 'a model named "turtlebot" is already there'),
            (spawn(BOX, ""), MODEL, "expected a name, found an empty one"),
            (spawn(BOX, "my box"), MODEL, 'found "my box"'),
            (spawn(BOX, "a", "name space"), MODEL, 'found "name space"'),
            (spawn(BOX, "a", x=math.nan), MODEL, "expected a finite pose"),
            (spawn(BOX, "a", y=math.inf), MODEL, "expected a finite pose"),
            (spawn(BOX, "a", yaw=-math.inf), MODEL, "expected a finite pose"),
            (spawn(BOX, "a", x=1e30), MODEL, "within 100 km"),
            (delete("turtlebo"), MODEL, 'there is no model "turtlebo" (did you mean "turtlebot"?)'),
            (delete(""), MODEL, 'there is no model ""'),
            (move("missing", 0, 0, 0), MODEL, 'there is no model "missing"'),
            (move("turtlebot", math.nan, 0, 0), MODEL, "expected a finite pose"),
            (move("turtlebot", 1e30, 0, 0), MODEL, "within 100 km"),
            (change_rate(0.0), "ValueError", "expected a rate above 0, found 0.0"),
            (model_markers("/nowhere.yaml"), MODEL, "there is no file /nowhere.yaml"),
        ):
            self.assertFalse(answer.success, expected)
            self.assertIn(expected, answer.message)
            self.assertEqual(answer.message.partition(": ")[0], error)

        self.assertEqual(ServerTopics.ask(), before)
        pose = Recorder("/odometry/ground_truth", Odometry).next().pose.pose.position
        self.assertLess(math.hypot(pose.x, pose.y), 1e-6)
        self.clock.next(10)

    def test_only_one_of_two_models_of_one_name_is_spawned(self):
        answers = []
        calls = [
            threading.Thread(target=lambda: answers.append(spawn(SLOW_MODEL, "twin")))
            for _ in range(2)
        ]
        for thread in calls:
            thread.start()
        for thread in calls:
            thread.join()
        self.addCleanup(delete, "twin")

        refused, spawned = sorted(answers, key=lambda answer: answer.success)
        self.assertTrue(spawned.success)
        self.assertFalse(refused.success)
        self.assertEqual(refused.message, 'ModelError: a model named "twin" is already there')

    def test_the_simulation_steps_while_a_slow_file_is_read(self):
        self.clock.next()
        begin = len(self.clock.messages)
        answer = spawn(SLOW_MODEL, "slow")
        steps = len(self.clock.messages) - begin
        self.addCleanup(delete, "slow")

        self.assertTrue(answer.success, answer.message)
        self.assertGreater(steps, 5)  # reading it takes a tenth of a second at least

    def test_pause_stops_time_and_resume_continues_it(self):
        self.addCleanup(call, "/resume", Empty)
        call("/pause", Empty)
        self._assert_time_stands()

        call("/resume", Empty)
        self.clock.next(5)
        call("/toggle_pause", Empty)
        self._assert_time_stands()
        call("/toggle_pause", Empty)
        self.clock.next(5)

    def _assert_time_stands(self):
        """In a pause: a new subscriber gets its time, and services work while time stands."""
        _, _, server = rospy.get_master().lookupNode("/flatland_server")
        with tcpros_client.subscribe(server, "/clock", Clock) as late_node:
            time_of_pause = tcpros_client.next_message(late_node, Clock)
        # Ticks from before the pause may arrive after the answer of the service.
        wait_until(lambda: self.clock.messages[-1] == time_of_pause, "the last tick")
        for _ in range(20):  # each answer comes from the simulation's loop
            self.assertFalse(delete("missing").success)
        self.assertEqual(self.clock.messages[-1], time_of_pause)

    def test_markers_follow_the_models(self):
        topics = Recorder("/flatland_server/debug/topics", DebugTopicList)
        wait_until(lambda: topics.messages, "the list of debug topics")
        self.assertEqual(
            topics.messages[-1].topics,
            ["layer/room", "layer/room_3d", "layer/hall", "layer/hall_3d", "model/turtlebot"],
        )

        self.assertTrue(spawn(BOX, "crate", "", 3.0, -2.0, 0.5).success)
        wait_until(lambda: "model/crate" in topics.messages[-1].topics, "the crate to be listed")
        crate = Recorder("/flatland_server/debug/model/crate", MarkerArray)
        shown = crate.next().markers[0]
        self.assertAlmostEqual(shown.pose.position.x, 3.0, delta=1e-5)
        self.assertAlmostEqual(shown.pose.orientation.z, math.sin(0.25), delta=1e-5)

        self.assertTrue(delete("crate").success)
        wait_until(
            lambda: crate.messages[-1].markers[0].action == Marker.DELETEALL, "the crate to vanish"
        )
        wait_until(lambda: "model/crate" not in topics.messages[-1].topics, "the list to shrink")

    def test_each_name_of_a_layer_has_its_walls_flat_and_upright(self):
        corners = {(-5, -3), (5, -3), (5, 3), (-5, 3)}
        for name, heights in (
            *(("layer/room", {0}), ("layer/hall", {0}), ("layers", {0})),
            *(("layer/room_3d", {0, 1}), ("layer/hall_3d", {0, 1})),
        ):
            walls = Recorder(f"/flatland_server/debug/{name}", MarkerArray)
            marker = wait_until(lambda w=walls: w.messages, f"~debug/{name}")[0].markers[-1]
            walls.close()
            found = {(round(p.x, 6), round(p.y, 6)) for p in marker.points}
            self.assertEqual((name, found), (name, corners))
            self.assertEqual((name, {p.z for p in marker.points}), (name, heights))
            self.assertEqual((marker.header.frame_id, marker.ns), ("map", "room"))

    def test_markers_of_a_model_are_latched_while_subscribed_to(self):
        topic = "/flatland_server/debug/model/latecomer"
        topics = Recorder("/flatland_server/debug/topics", DebugTopicList)
        self.assertTrue(spawn(BOX, "latecomer", "", -3.0, -2.0).success)
        self.addCleanup(delete, "latecomer")
        first = Recorder(topic, MarkerArray)
        wait_until(lambda: first.messages, "the markers")
        is_latched = rospy.get_param("/flatland_server/rospy_patches", True)
        header = first.messages[0]._connection_header
        self.assertEqual(header["latching"], "1" if is_latched else "0")
        self.assertAlmostEqual(x_of(first.messages[-1]), -3.0, delta=1e-5)
        first.close()

        self.assertTrue(move("latecomer", -1.0, -2.0).success)
        self.assertTrue(spawn(BOX, "other", "", 3.0, -2.0).success)
        wait_until(lambda: "model/other" in topics.messages[-1].topics, "an update of the markers")
        self.assertTrue(delete("other").success)
        wait_until(lambda: "model/other" not in topics.messages[-1].topics, "another update")
        second = Recorder(topic, MarkerArray)
        wait_until(lambda: second.messages, "the markers")
        self.assertAlmostEqual(x_of(second.messages[0]), -1.0, delta=1e-5)
        second.close()
        topics.close()

#!/usr/bin/python3
"""Time and state over a real master: equal runs in lockstep, resets, reloads, saved states."""

import math
import subprocess
import sys
import tempfile
import threading
import unittest
from contextlib import contextmanager
from pathlib import Path

import rospkg
import rospy
from flatland_msgs.msg import DebugTopicList, SimulationState
from flatland_msgs.srv import LoadState, OpenWorld, Reset, SaveState, Seek, Step
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from rostest_tools import Recorder
from sensor_msgs.msg import LaserScan
from service_calls import call, delete, spawn
from std_srvs.srv import Empty, Trigger
from visualization_msgs.msg import MarkerArray
from waiting import wait_until

from flatland_server import World, plain_data
from flatland_server.messages.wire_form import serialized
from flatland_server.testing import Harness

BOX = Path(rospkg.RosPack().get_path("flatland_server")) / "worlds" / "office" / "box.model.yaml"
STEPS = 120
"""0.6 s: 18 messages of odometry and 3 scans, whether time begins at 0 or at 0.6 s."""
TIME_LIMIT = 10.0  # s of real time, for a command to arrive


def command(index):
    """The speed [m/s] and turn [rad/s] commanded before a step."""
    return 0.2 + 0.1 * math.sin(0.1 * index), math.cos(0.05 * index)


def content(message):
    """A message without its sequence number, as bytes."""
    message.header.seq = 0
    return serialized(message)


def physics(state):
    """The part of a state that the core saves."""
    return plain_data.loads(state)["physics"]


def step(count=1, expect=(), timeout=TIME_LIMIT):
    return call("/step", Step, count, list(expect), timeout)


def reset(keep_time=False, seed=None):
    return call("/reset", Reset, not keep_time, seed is not None, seed or 0)


@contextmanager
def busy_machine():
    """Keeps all cores busy."""
    program = [sys.executable, "-c", "while True: pass"]
    workers = [subprocess.Popen(program) for _ in range(4)]
    try:
        yield
    finally:
        for worker in workers:
            worker.kill()
            worker.wait()


class State(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.clock = Recorder("/clock", Clock)
        cls.odometry = Recorder("/wheel_odom", Odometry)
        cls.scan = Recorder("/scan", LaserScan)
        cls.cmd_vel = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
        for recorder in (cls.clock, cls.odometry, cls.scan):
            recorder.next()
        wait_until(cls.cmd_vel.get_num_connections, "the drive to subscribe")
        call("/pause", Empty)

    def setUp(self):
        self.assertTrue(reset().success)

    def publish(self, speed, turn):
        twist = Twist()
        twist.linear.x, twist.angular.z = speed, turn
        self.cmd_vel.publish(twist)

    def drive(self):
        """Drives in lockstep, a command for each step; returns the sensors' messages by time."""
        recorders = (self.odometry, self.scan)
        begin = [len(recorder.messages) for recorder in recorders]
        make_step = rospy.ServiceProxy("/step", Step, persistent=True)
        for index in range(STEPS):
            self.publish(*command(index))
            answer = make_step(1, ["/cmd_vel"], TIME_LIMIT)
            self.assertTrue(answer.success, answer.message)
        make_step.close()
        said = {}
        for recorder, first, rate in zip(recorders, begin, (30, 5)):
            count = round(STEPS * 0.005 * rate)
            wait_until(
                lambda r=recorder, f=first, c=count: len(r.messages) >= f + c,
                f"{count} messages on {recorder.topic}",
            )
            for message in recorder.messages[first:]:
                said[recorder.topic, message.header.stamp.to_nsec()] = content(message)
        return said

    def test_lockstep_gives_equal_runs_on_a_busy_machine(self):
        first = self.drive()
        self.assertEqual(len(first), 18 + 3)

        with busy_machine():
            self.assertTrue(reset().success)
            self.assertEqual(self.drive(), first)
        self.assertTrue(reset(seed=5).success)
        self.assertNotEqual(self.drive(), first)
        self.assertTrue(reset(seed=0).success)
        self.assertEqual(self.drive(), first)

    def test_the_same_commands_in_process_give_the_same_run(self):
        world = Path(rospy.get_param("/flatland_server/world_path"))
        simulation = Harness(World.from_file(world, seed=0))
        said = {}
        for index in range(STEPS):
            simulation.drive(*command(index)).run()
            for topic in ("/wheel_odom", "/scan"):
                message = simulation.last(topic)
                said[topic, message.header.stamp.to_nsec()] = content(message)

        self.assertEqual(said, self.drive())

    def test_a_run_goes_on_from_a_saved_state(self):
        self.drive()
        self.assertTrue(spawn(BOX, "box", "", 1.5, 0.0).success)
        with tempfile.TemporaryDirectory() as folder:
            file = str(Path(folder) / "room.state")
            saved = call("/save_state", SaveState, file)
            self.assertTrue(saved.success, saved.message)
            self.assertEqual((saved.message, saved.without_hooks), ("", []))
            first = self.drive()
            self.assertTrue(delete("box").success)

            loaded = call("/load_state", LoadState, file)
            self.assertTrue(loaded.success, loaded.message)
            self.assertEqual(self.drive(), first)
            self.assertEqual(step().time.to_nsec(), (2 * STEPS + 1) * 5_000_000)
            self.assertTrue(delete("box").success)

            Path(file).write_text("nonsense")
            refused = call("/load_state", LoadState, file)
            self.assertFalse(refused.success)
            self.assertEqual(
                refused.message, "StateError: expected the state of a world, found something else"
            )
        for service, path in ((SaveState, "state"), (LoadState, "state")):
            name = "/save_state" if service is SaveState else "/load_state"
            answer = call(name, service, path)
            self.assertRegex(answer.message, "^StateError: expected an absolute path .*, found")
        answer = call("/load_state", LoadState, "~/nowhere/state")
        self.assertIn(f"{Path.home()}/nowhere/state: cannot be read: No such file", answer.message)
        answer = call("/load_state", LoadState, "/nowhere/state")
        self.assertIn("StateError: /nowhere/state: cannot be read: No such file", answer.message)

    def test_any_time_of_the_run_can_be_sought_with_its_commands(self):
        self.drive()
        world = Path(rospy.get_param("/flatland_server/world_path"))
        simulation = Harness(World.from_file(world, seed=0))
        for index in range(STEPS // 2):
            simulation.drive(*command(index)).run()
        simulation.drive(*command(STEPS // 2)).transport.process()
        state = Recorder("/flatland_server/state", SimulationState)
        published = len(self.odometry.messages)

        answer = call("/seek", Seek, simulation.time)

        self.assertTrue(answer.success, answer.message)
        self.assertEqual(self.saved_physics(), physics(simulation.save_state()))
        now = simulation.timekeeper.nanoseconds
        said = state.next(holds=lambda said: said.stamp.to_nsec() == now)
        self.assertEqual((said.history_begin.to_sec(), said.history_end.to_sec()), (0.0, 0.6))
        self.assertTrue(said.paused)
        self.assertEqual(len(self.odometry.messages), published)  # a replay publishes nothing
        self.assertEqual(step().time.to_nsec(), (STEPS // 2 + 1) * 5_000_000)
        simulation.run()
        self.assertEqual(self.saved_physics(), physics(simulation.save_state()))
        refused = call("/seek", Seek, 0.6)
        self.assertEqual(
            refused.message,
            "UsageError: expected a time from 0 to 0.305 s, which the history has, found 0.6",
        )

    def saved_physics(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "room.state"
            self.assertTrue(call("/save_state", SaveState, str(file)).success)
            return physics(file.read_bytes())

    def test_steps_wait_for_commands_that_are_late(self):
        command = threading.Timer(0.2, self.publish, (0.2, 0.0))
        command.start()
        answer = step(10, ["cmd_vel"])
        command.join()

        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.time.to_nsec(), 50_000_000)

    def test_wrong_steps_are_refused_with_a_reason(self):
        for arguments, expected in (
            ((0,), "ValueError: expected 1 step or more, found 0"),
            ((-3,), "ValueError: expected 1 step or more, found -3"),
            ((1, ["/cmd_vel"], -1.0), "ValueError: expected a timeout above 0 s, found -1.0"),
            (
                (1, ["/cmd_val"]),
                'ValueError: nothing in the simulation subscribes to /cmd_val (did you mean "/cm',
            ),
            (
                (1, ["/cmd_vel"], 0.1),
                "FlatlandError: no message has come on /cmd_vel since the last step",
            ),
        ):
            answer = step(*arguments)
            self.assertFalse(answer.success)
            self.assertTrue(answer.message.startswith(expected), answer.message)
        call("/resume", Empty)
        try:
            answer = step()
        finally:
            call("/pause", Empty)
        self.assertEqual(answer.message, "FlatlandError: the simulation is not paused")

    def test_only_one_request_makes_steps_at_a_time(self):
        refusal = "FlatlandError: the steps of another request are being made"
        answers = []

        def wait_for_a_command():
            answers.append(step(1, ["/cmd_vel"]))
            if answers[-1].message == refusal:  # by a step that this test asks for below
                wait_for_a_command()

        waits = threading.Thread(target=wait_for_a_command, daemon=True)
        waits.start()
        refused = wait_until(
            lambda: next((a for a in (step(),) if not a.success), None), "a step to be refused"
        )
        self.publish(0.0, 0.0)
        waits.join(20)

        self.assertEqual(refused.message, refusal)
        self.assertTrue(answers[-1].success, answers[-1].message)

    def test_time_goes_back_at_a_reset_unless_it_is_kept(self):
        self.assertEqual(step(100).time.to_nsec(), 500_000_000)

        self.assertTrue(reset(keep_time=True).success)
        self.assertEqual(step().time.to_nsec(), 505_000_000)
        begin = len(self.clock.messages)
        self.assertTrue(reset().success)

        wait_until(
            lambda: [m for m in self.clock.messages[begin:] if m.clock.to_nsec() == 0],
            "/clock to begin again",
        )

    def test_a_reset_removes_spawned_models_and_keeps_connections(self):
        connections = self.odometry._subscriber.impl.connections
        before = list(connections)
        self.assertTrue(spawn(BOX, "box", "", 1.5, 0.0).success)

        self.assertTrue(reset().success)

        self.assertFalse(delete("box").success)
        self.assertEqual(list(connections), before)

    def test_the_world_file_is_loaded_again(self):
        truth = Recorder("/odometry/ground_truth", Odometry)
        self.addCleanup(truth.close)
        wait_until(truth._subscriber.get_num_connections, "the ground truth")
        topics = Recorder("/flatland_server/debug/topics", DebugTopicList)
        self.addCleanup(topics.close)
        wait_until(lambda: topics.messages, "the list of debug topics")
        self.assertIn("layer/hall", topics.messages[-1].topics)
        for name, value in (("/robot_x", 1.5), ("/second_name", "lobby")):
            rospy.set_param(name, value)
            self.addCleanup(rospy.delete_param, name)

        answer = call("/reload_world", Trigger)
        self.assertTrue(answer.success, answer.message)
        wait_until(lambda: "layer/lobby" in topics.messages[-1].topics, "the layer's other name")
        self.assertNotIn("layer/hall", topics.messages[-1].topics)
        lobby = Recorder("/flatland_server/debug/layer/lobby", MarkerArray)
        self.addCleanup(lobby.close)
        walls = wait_until(lambda: lobby.messages, "its walls")[-1].markers[-1]
        self.assertGreater(len(walls.points), 3)
        step()
        moved = wait_until(lambda: truth.messages, "the ground truth")[-1]
        self.assertAlmostEqual(moved.pose.pose.position.x, 1.5)

        rospy.set_param("/robot_x", "far")
        answer = call("/reload_world", Trigger)
        self.assertFalse(answer.success)
        self.assertRegex(answer.message, r'^YamlError: .*noisy_room\.yaml:\d+: .*found \["far"')
        self.assertTrue(step().success)

    def test_another_world_is_opened(self):
        topics = Recorder("/flatland_server/debug/topics", DebugTopicList)
        self.addCleanup(topics.close)
        own = rospy.get_param("/flatland_server/world_path")
        self.addCleanup(self.return_to, own)
        step(5)

        answer = call("/open_world", OpenWorld, "/nowhere/world.yaml")
        self.assertFalse(answer.success)
        self.assertIn("/nowhere/world.yaml", answer.message)
        self.assertRegex(call("/open_world", OpenWorld, "a").message, "^FlatlandError: .*absolute")
        self.assertEqual(rospy.get_param("/flatland_server/world_path"), own)

        answer = call(
            "/open_world", OpenWorld, "package://flatland_server/worlds/test_room/world.yaml"
        )
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(step().time.to_sec(), 0.005)  # still paused, and time begins at 0
        wait_until(
            lambda: topics.messages and "model/turtlebot" in topics.messages[-1].topics, "its robot"
        )
        self.assertTrue(rospy.get_param("/flatland_server/world_path").endswith("room/world.yaml"))

    def return_to(self, own):
        """Opens the world of the other tests; only that one has the topic /wheel_odom."""
        call("/open_world", OpenWorld, own)
        seen = len(self.odometry.messages)
        wait_until(lambda: step(10) and len(self.odometry.messages) > seen, "/wheel_odom")


if __name__ == "__main__":
    import rostest

    # rospy's own subscription to /clock has a queue of one message, which ours would share.
    rospy.init_node("state_rostest", disable_rostime=True)
    rostest.rosrun("flatland_server", "state", State, sys.argv)

"""Shared by the rostests of plugins: robots with the plugin, and checks of all they publish.

A case has a table of topics and frames. It listens to them for a while, and has a test for each
column. A `PluginCase` spawns its model for that, with a namespace and without one, and deletes it
in the end.
"""

import math
import traceback
from pathlib import Path
from typing import ClassVar, Dict, List, Tuple

import rospy
from geometry_msgs.msg import Transform, Twist
from readings import Pose, stamp_of
from robots import Frame, Robot, Topic
from rosgraph_msgs.msg import Clock
from rostest_tools import Recorder, RecordingCase
from service_calls import ServerTopics, delete, spawn, topic_types
from tf2_msgs.msg import TFMessage
from waiting import wait_until

WORLDS = Path(__file__).resolve().parent / "worlds"
STEP = 5_000_000  # ns
LISTENED = 1.2  # s of simulated time


class ListeningCase(RecordingCase):
    """Base of tests of what robots publish.

    Attributes:
        published, frames: the topics and frames of each robot.
        robots: the robots with these topics; the world counts as a robot without a namespace.
    """

    published: ClassVar[Tuple[Topic, ...]] = ()
    frames: ClassVar[Tuple[Frame, ...]] = ()
    robots: ClassVar[Tuple[Robot, ...]] = (Robot("world", "", 0.0, 0.0, 0.0),)
    _failure: ClassVar[str] = ""

    @classmethod
    def setUpClass(cls) -> None:
        try:
            cls._prepare()
        except Exception:  # rosunit would not show the traceback
            cls._failure = traceback.format_exc()

    def setUp(self) -> None:
        if self._failure:
            self.fail(self._failure)

    @classmethod
    def _prepare(cls) -> None:
        cls.clock = cls.record("/clock", Clock)
        cls.tf = cls.record("/tf", TFMessage)
        cls.clock.next()
        cls.spawn_robots()
        cls.recorders = {
            robot.topic(topic.name): cls.record(robot.topic(topic.name), topic.type)
            for robot in cls.robots
            for topic in cls.published
        }
        cls.get_going()
        for name, recorder in cls.recorders.items():
            wait_until(lambda r=recorder: r.messages, f"a message on {name}")
        cls._listen()

    @classmethod
    def spawn_robots(cls) -> None:
        """Spawns the robots, before their topics are recorded."""

    @classmethod
    def get_going(cls) -> None:
        """Sets the robots in motion, before listening."""

    @classmethod
    def _listen(cls) -> None:
        """Counts the messages of each topic for a while, and keeps all stamps."""
        counts = {name: -len(recorder.messages) for name, recorder in cls.recorders.items()}
        cls.begin = cls.clock.next().clock.to_nsec()
        cls.end = cls.clock.next(
            holds=lambda m: m.clock.to_nsec() >= cls.begin + LISTENED * 1e9
        ).clock.to_nsec()
        cls._wait_for_what_is_on_its_way()
        cls.noted = cls.clock.messages[-1].clock.to_nsec()
        cls.counts = {
            name: counts[name] + len(recorder.messages) for name, recorder in cls.recorders.items()
        }
        cls.stamps = {
            name: [stamp_of(message) for message in list(recorder.messages)]
            for name, recorder in cls.recorders.items()
            if stamp_of(recorder.messages[0]) is not None
        }
        cls.sent: Dict[Tuple[str, str], List[int]] = {}  # stamps by parent and child
        for message in list(cls.tf.messages):
            for transform in message.transforms:
                edge = (transform.header.frame_id, transform.child_frame_id)
                cls.sent.setdefault(edge, []).append(transform.header.stamp.to_nsec())

    @classmethod
    def _wait_for_what_is_on_its_way(cls) -> None:
        due = [
            (cls.recorders[robot.topic(topic.name)], topic.rate)
            for robot in cls.robots
            for topic in cls.published
        ]
        due += [(cls.tf, max(frame.rate for frame in cls.frames))] if cls.frames else []
        for recorder, rate in due:
            if stamp_of(recorder.messages[-1]) is not None:
                oldest = cls.end - round(1e9 / rate)
                wait_until(
                    lambda r=recorder, o=oldest: stamp_of(r.messages[-1]) > o,
                    f"the last message on {recorder.topic}",
                )

    @classmethod
    def drive(cls, topic: str, x: float = 0.0, y: float = 0.0, turn: float = 0.0) -> None:
        """Commands a velocity, which holds until the next command."""
        publisher = rospy.Publisher(topic, Twist, queue_size=1, latch=True)
        cls.addClassCleanup(publisher.unregister)
        twist = Twist()
        twist.linear.x, twist.linear.y, twist.angular.z = x, y, turn
        publisher.publish(twist)

    def recorder_of(self, robot: Robot, name: str) -> Recorder:
        """The recorder of a robot's topic."""
        return self.recorders[robot.topic(name)]

    def transform(self, robot: Robot, child: str, stamp: rospy.Time) -> Transform:
        """The transform to a robot's frame with a stamp."""
        child = robot.frame(child)

        def found() -> List[Transform]:
            return [
                t.transform
                for message in self.tf.messages
                if message.transforms[0].header.stamp == stamp
                for t in message.transforms
                if t.child_frame_id == child
            ]

        return wait_until(found, f"the transform of {child} at {stamp.to_sec()}")[0]

    def assert_pose(self, pose: Pose, expected: Pose, delta: float = 1e-5) -> None:
        """Fails if a pose differs by more than `delta` [m, m, rad]."""
        for value, number in zip(pose[:2], expected[:2]):
            self.assertAlmostEqual(value, number, delta=delta, msg=f"{pose} != {expected}")
        turn = math.remainder(pose[2] - expected[2], math.tau)
        self.assertAlmostEqual(turn, 0.0, delta=delta, msg=f"{pose} != {expected}")

    def assert_rate(self, name: str, stamps: List[int], rate: float) -> None:
        """Fails if stamps are not a period apart; a loaded machine may lose a few."""
        period = round(1e9 / rate)
        gaps = [b - a for a, b in zip(stamps, stamps[1:])]
        self.assertEqual({gap % period for gap in gaps}, {0}, f"{name}: {sorted(set(gaps))}")
        count = len([stamp for stamp in stamps if self.begin <= stamp <= self.end])
        expected = (self.end - self.begin) / period
        self.assertAlmostEqual(count, expected, delta=1.5 + 0.05 * expected, msg=name)

    def test_topics_have_their_types(self):
        types = topic_types()
        for robot in self.robots:
            for topic in self.published:
                name = robot.topic(topic.name)
                self.assertEqual((name, types[name]), (name, topic.type._type))

    def test_topics_come_at_their_rates(self):
        for robot in self.robots:
            for topic in self.published:
                name = robot.topic(topic.name)
                if name in self.stamps:
                    self.assert_rate(name, self.stamps[name], topic.rate)
                else:  # by the times of arrival, compared with the clock
                    expected = topic.rate * (self.end - self.begin) * 1e-9
                    delta = 2.0 + 0.15 * expected
                    self.assertAlmostEqual(self.counts[name], expected, delta=delta, msg=name)

    def test_messages_tell_their_frames(self):
        for robot in self.robots:
            for topic in self.published:
                name = robot.topic(topic.name)
                for message in list(self.recorders[name].messages) if topic.frame else ():
                    self.assertEqual(message.header.frame_id, robot.frame(topic.frame), name)
                    if topic.child_frame:
                        self.assertEqual(
                            message.child_frame_id, robot.frame(topic.child_frame), name
                        )

    def test_stamps_are_those_of_the_clock(self):
        ticks = {m.clock.to_nsec() for m in list(self.clock.messages)}
        self.assertEqual({tick % STEP for tick in ticks}, {0})
        for name, stamps in [*self.stamps.items(), *self.sent.items()]:
            within = {stamp for stamp in stamps if self.begin <= stamp <= self.end}
            self.assertGreater(len(within), 5, name)
            self.assertEqual(within - ticks, set(), name)
            self.assertLess(max(stamps), self.noted + 0.5e9, name)
            self.assertGreater(max(stamps), self.noted - 0.5e9, name)

    def test_frames_have_their_parents_and_come_at_their_rates(self):
        edges = {
            (robot.frame(frame.parent), robot.frame(frame.child)): frame.rate
            for robot in self.robots
            for frame in self.frames
        }
        self.assertEqual(set(self.sent), set(edges))
        for edge, rate in edges.items():
            self.assert_rate(" -> ".join(edge), self.sent[edge], rate)


class PluginCase(ListeningCase):
    """Base of the tests of a plugin of models.

    Attributes:
        model: its file in worlds/.
        subscribed: the topics that each robot subscribes to.
        robots: where they are spawned.
    """

    model: ClassVar[str]
    subscribed: ClassVar[Tuple[str, ...]] = ()
    robots = (Robot("plain", "", -2.0, 1.2, 0.3), Robot("spaced", "ns", -2.0, -1.2, -0.4))

    @classmethod
    def spawn_robots(cls) -> None:
        before = ServerTopics.ask()
        for robot in cls.robots:
            cls._spawn(robot)
            cls.addClassCleanup(delete, robot.name)
        cls.topics = ServerTopics.ask().without(before)

    @classmethod
    def _spawn(cls, robot: Robot) -> None:
        answer = spawn(WORLDS / f"{cls.model}.model.yaml", *robot)
        assert answer.success, answer.message

    def test_each_robot_has_the_topics_and_no_others(self):
        published = {r.topic(t.name) for r in self.robots for t in self.published}
        self.assertEqual(self.topics.published, published)
        self.assertEqual(
            self.topics.subscribed, {r.topic(n) for r in self.robots for n in self.subscribed}
        )

    def test_a_deleted_model_takes_its_topics_and_frames_along(self):
        before = ServerTopics.ask()
        guest = Robot("guest", "guest_ns", 2.5, 0.0, 0.0)

        self._spawn(guest)
        self.clock.next(20)
        topics = ServerTopics.ask().without(before)
        answer = delete(guest.name)

        self.assertEqual(topics.published, {guest.topic(t.name) for t in self.published})
        self.assertEqual(topics.subscribed, {guest.topic(name) for name in self.subscribed})
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(ServerTopics.ask(), before)

        def newest() -> Dict[str, int]:
            return {
                t.child_frame_id: t.header.stamp.to_nsec()
                for message in list(self.tf.messages)
                for t in message.transforms
                if t.child_frame_id.startswith("guest_ns_")
            }

        wait_until(
            lambda: self.clock.next().clock.to_nsec() > max(newest().values(), default=0) + 3e8,
            "the frames of a deleted model to be sent no more",
        )
        self.assertEqual(set(newest()), {guest.frame(frame.child) for frame in self.frames})

"""Training runs over a real master: many calls in each episode, and steps of one control period."""

from functools import partial
from pathlib import Path

import rospkg
import rospy
from flatland_msgs.msg import Model, MoveModelMsg
from flatland_msgs.msg import StepWorld as StepWorldMessage
from flatland_msgs.srv import (
    DeleteModels,
    Reset,
    SpawnModel,
    SpawnModelRequest,
    SpawnModels,
    Step,
    StepWorld,
)
from geometry_msgs.msg import Pose2D
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock, Log
from rostest_tools import RecordingCase
from sensor_msgs.msg import LaserScan
from service_calls import call
from std_srvs.srv import Empty
from waiting import wait_until

DISC = "bodies:\n- name: disc\n  footprints:\n  - {type: circle, radius: 0.1, density: 1}\n"
BOX = Path(rospkg.RosPack().get_path("flatland_server")) / "worlds" / "office" / "box.model.yaml"
FAILS_TO_START = Path(__file__).resolve().parent / "worlds" / "fails_to_start.model.yaml"
PERIOD, STEP = 100_000_000, 5_000_000  # ns


def spawn_text(text, name, x=0.0, y=0.0):
    request = SpawnModelRequest(yaml_path=text, name=name, ns="", pose=Pose2D(x, y, 0.0))
    return call("/spawn_model_from_string", SpawnModel, request)


def spawn_all(*models):
    """The answer of /spawn_models to pairs of a file and a name."""
    poses = [Pose2D(index, -2.0, 0.0) for index in range(len(models))]
    return call(
        "/spawn_models",
        SpawnModels,
        [Model(str(path), name, "", pose) for (path, name), pose in zip(models, poses)],
    )


def delete_all(*names):
    return call("/delete_models", DeleteModels, names)


def time_after_a_step():
    """Simulated time [ns]; /step is refused unless the simulation is paused."""
    answer = call("/step", Step, 1, [], 0.0)
    assert answer.success, answer.message
    return answer.time.to_nsec()


class Training(RecordingCase):
    @classmethod
    def setUpClass(cls):
        cls.scan = cls.record("/scan", LaserScan)
        cls.truth = cls.record("/odometry/ground_truth", Odometry)
        cls.clock = cls.record("/clock", Clock)
        cls.log = cls.record("/rosout", Log)
        cls.move = rospy.Publisher("/move_model", MoveModelMsg, queue_size=10)
        cls.addClassCleanup(cls.move.unregister)
        cls.addClassCleanup(call, "/resume", Empty)
        wait_until(cls.move.get_num_connections, "the server to subscribe to /move_model")

    def pause(self):
        call("/pause", Empty)
        self.addCleanup(call, "/resume", Empty)

    def step_world(self):
        """A publisher that the server listens to, while the simulation is paused."""
        publisher = rospy.Publisher("/step_world", StepWorldMessage, queue_size=10)
        self.addCleanup(publisher.unregister)
        wait_until(publisher.get_num_connections, "the server to subscribe to /step_world")
        self.pause()
        return publisher

    def succeed(self, answer):
        self.assertTrue(answer.success, answer.message)

    def test_a_training_run_has_a_scan_in_each_period(self):
        names = [f"disc_{index}" for index in range(20)]
        self.scan.next()
        for episode in range(3):
            call("/pause", Empty)
            self.succeed(call("/reset", Reset, True, False, 0))
            for index, name in enumerate(names):
                self.succeed(spawn_text(DISC, name, -4.5 + 0.4 * index, -2.5))
            start = 0.5 * episode
            self.move.publish(MoveModelMsg("turtlebot", Pose2D(start, 1.0, 0.0)))

            def robot_is_at_start(start=start):
                call("/step_world", StepWorld)
                position = self.truth.messages[-1].pose.pose.position
                return abs(position.x - start) < 1e-5 and abs(position.y - 1.0) < 1e-5

            wait_until(robot_is_at_start, "the robot to be moved")
            begin = time_after_a_step()
            scans = len(self.scan.messages)
            for _ in range(10):
                call("/step_world", StepWorld)
            self.assertEqual(time_after_a_step() - begin, 10 * PERIOD + STEP)
            wait_until(lambda n=scans: len(self.scan.messages) >= n + 10, "a scan in each period")
            self.assertAlmostEqual(min(self.scan.messages[-1].ranges), 2.0, delta=0.01)
            self.succeed(delete_all(*names))
            call("/resume", Empty)

    def test_step_world_advances_time_by_the_control_period(self):
        self.pause()
        begin = time_after_a_step()

        call("/step_world", StepWorld)
        call("/step_world", Empty)  # a client may use either class

        self.assertEqual(time_after_a_step() - begin, 2 * PERIOD + STEP)
        call("/resume", Empty)
        call("/step_world", Empty)
        refused = call("/step", Step, 1, [], 0.0)
        self.assertIn("the simulation is not paused", refused.message)

    def test_topic_step_world_advances_by_its_value_or_one_step(self):
        step_world = self.step_world()
        begin = time_after_a_step()

        for duration in (0.2, 0.0, 0.2):  # none is lost while the steps of another are made
            step_world.publish(duration)

        wait_until(
            lambda: self.clock.messages[-1].clock.to_nsec() >= begin + 81 * STEP, "the steps"
        )
        self.assertEqual(time_after_a_step() - begin, 82 * STEP)
        step_world.publish(0.001)
        warning = "/step_world: UsageError: expected required_time to be a multiple of the step"
        wait_until(lambda: any(m.msg.startswith(warning) for m in self.log.messages), warning)

    def test_a_hundred_episodes_stepped_by_topic(self):
        """The calls of Arena-Rosnav's environments: discs from texts, a message for each scan."""
        self.assertEqual(StepWorldMessage._md5sum, "db98664cbe4523fcf94ecdf73a95fa46")
        step_world = self.step_world()
        discs = [Model(DISC, f"disc_{index}", "", Pose2D(index, -2.0, 0.0)) for index in range(3)]
        for _ in range(100):
            self.succeed(call("/spawn_models_from_string", SpawnModels, discs))
            for _ in range(2):
                scans = len(self.scan.messages)
                step_world.publish(0.1)
                wait_until(
                    lambda n=scans: len(self.scan.messages) > n, "the period's scan", interval=0.001
                )
            self.succeed(delete_all(*(disc.name for disc in discs)))

    def test_models_are_spawned_and_deleted_together_or_not_at_all(self):
        for second, expected in (
            (("nowhere.yaml", "b"), 'ModelError: models[1] "b": there is no file '),
            ((BOX, "a"), 'ModelError: models[1] "a": a model named "a" is already there'),
            ((FAILS_TO_START, "b"), f'YamlError: models[1] "b": {FAILS_TO_START}:'),
        ):
            answer = spawn_all((BOX, "a"), second)
            self.assertFalse(answer.success)
            self.assertIn(expected, answer.message)
        self.succeed(spawn_all((BOX, "a"), (BOX, "b")))
        for names, expected in (
            (["a", "c"], 'ModelError: name[1] "c": there is no model "c"'),
            (["a", "b", "a"], 'ModelError: name[2] "a": the name is given twice'),
        ):
            answer = delete_all(*names)
            self.assertFalse(answer.success)
            self.assertEqual(answer.message.partition(" (did")[0], expected)
        self.succeed(delete_all("b", "a"))

    def test_models_are_spawned_from_texts_together_or_not_at_all(self):
        def spawn(*texts):
            models = [
                Model(text, f"text_{index}", "", Pose2D()) for index, text in enumerate(texts)
            ]
            return call("/spawn_models_from_string", SpawnModels, models)

        answer = spawn(DISC, "bodies: 1")
        self.assertFalse(answer.success)
        self.assertIn('models[1] "text_1": <text of text_1>:1: bodies', answer.message)
        self.succeed(spawn(DISC, DISC))
        self.succeed(delete_all("text_0", "text_1"))

    def test_an_error_in_a_text_has_its_line_and_names_the_model(self):
        answer = spawn_text(DISC.replace("0.1", "wide"), "disc")

        self.assertFalse(answer.success)
        expected = "YamlError: <text of disc>:4: bodies[0].footprints[0].radius: expected a number"
        self.assertTrue(answer.message.startswith(expected), answer.message)
        self.assertIn('found "wide"', answer.message)

    def test_a_bad_move_model_message_is_a_warning_with_the_topic(self):
        def is_warned(error, *message):
            self.move.publish(*message)  # again: this node may not have the server's log yet
            warning = f"/move_model: ModelError: {error}"
            return any(m.msg.startswith(warning) for m in self.log.messages)

        for error, *message in (
            ('there is no model "nobody"', "nobody", Pose2D()),
            ("expected a finite pose", "turtlebot", Pose2D(float("nan"), 0.0, 0.0)),
        ):
            wait_until(partial(is_warned, error, *message), error)

"""/diagnostics over a real master, with plugins that fail."""

from pathlib import Path

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Clock, Log
from rostest_tools import Recorder, RecordingCase
from service_calls import SERVER, ServerTopics, call, delete, spawn
from std_msgs.msg import Empty
from std_srvs.srv import Empty as EmptyService
from tf2_msgs.msg import TFMessage

MODELS = Path(__file__).resolve().parent / "worlds"


class Diagnostics(RecordingCase):
    @classmethod
    def setUpClass(cls):
        cls.clock = cls.record("/clock", Clock)
        cls.tf = cls.record("/tf", TFMessage)
        cls.log = cls.record("/rosout", Log)
        cls.diagnostics = cls.record("/diagnostics", DiagnosticArray)
        cls.clock.next()

    def statuses(self, holds):
        """The statuses by name, of the next message for which `holds(statuses)`."""

        def by_name(message):
            return {status.name: status for status in message.status}

        return by_name(self.diagnostics.next(holds=lambda m: holds(by_name(m))))

    def test_a_running_simulation_is_ok(self):
        """test_real_time_timer.py has a message each second, test_pacer.py the figures."""
        first = self.diagnostics.next()
        last = self.diagnostics.next()
        self.assertGreater(last.header.stamp, first.header.stamp)

        (status,) = last.status
        self.assertEqual(status.name, f"{SERVER[1:]}: simulation")
        self.assertEqual((status.level, status.message), (DiagnosticStatus.OK, "running"))
        values = {value.key: value.value for value in status.values}
        now = last.header.stamp.to_sec()
        self.assertAlmostEqual(float(values["simulated time [s]"]), now, delta=0.006)
        self.assertGreater(float(values["times real time"]), 0.0)
        median = float(values["step period, median [ms]"])
        self.assertGreater(median, 0.0)
        self.assertGreaterEqual(float(values["step period, 99th percentile [ms]"]), median)
        self.assertEqual(values["models"], "1")
        self.assertEqual(values["plugins"], "4")
        self.assertEqual(values["plugins that failed"], "0")

    def test_a_paused_simulation_is_ok_too(self):
        call("/pause", EmptyService)
        self.addCleanup(call, "/resume", EmptyService)
        paused = self.statuses(lambda s: s[f"{SERVER[1:]}: simulation"].message == "paused")
        status = paused[f"{SERVER[1:]}: simulation"]
        self.assertEqual(status.level, DiagnosticStatus.OK)

    def test_diagnostics_show_a_failed_plugin_until_it_is_deleted(self):
        before = ServerTopics.ask()
        answer = spawn(MODELS / "fails_later.model.yaml", "robot", "ns")
        self.assertTrue(answer.success, answer.message)
        self.addCleanup(delete, "robot")
        alive = Recorder("/ns/alive", Empty)
        alive.next(2)
        fail = rospy.Publisher("/ns/fail", Empty, queue_size=1, latch=True)
        self.addCleanup(fail.unregister)
        simulation, name = f"{SERVER[1:]}: simulation", f"{SERVER[1:]}: plugin robot/sensor"
        logged = len(self.log.messages)

        fail.publish()

        statuses = self.statuses(lambda s: name in s and simulation in s)
        status = statuses[name]
        self.assertEqual(
            (status.level, status.message),
            (
                DiagnosticStatus.ERROR,
                "switched off: before_physics_step: RuntimeError: the battery is empty",
            ),
        )
        values = {value.key: value.value for value in status.values}
        self.assertEqual(values, {"type": "FailsLater", "model": "robot"})
        status = statuses[simulation]
        self.assertEqual((status.level, status.message), (DiagnosticStatus.OK, "running"))
        values = {value.key: value.value for value in status.values}
        self.assertEqual((values["plugins"], values["plugins that failed"]), ("5", "1"))
        self.clock.next(20)  # the simulation continues, and the plugin is not called again
        errors = [m for m in self.log.messages[logged:] if m.level >= Log.ERROR]
        self.assertEqual([m.name for m in errors], [SERVER])
        self.assertIn('the plugin "robot/sensor" failed in before_physics_step', errors[0].msg)
        self.assertIn("Traceback (most recent call last):", errors[0].msg)
        self.assertIn("RuntimeError: the battery is empty", errors[0].msg)
        self.assertEqual(ServerTopics.ask(), before)  # its topics are gone with it

        self.assertTrue(delete("robot").success)
        self.statuses(lambda s: simulation in s and name not in s)

    def test_a_model_with_a_failing_third_plugin_leaves_nothing(self):
        self.clock.next(5)
        before = ServerTopics.ask()
        for model, reason in (
            (
                "fails_to_start",
                'fails_to_start.model.yaml:17: plugins[2] "sensor": does not start: RuntimeError: '
                "no battery",
            ),
            (
                "misspelt",
                'misspelt.model.yaml:17: plugins[2] "laser": unknown key "raneg" (did you mean '
                '"range"?)',
            ),
        ):
            begin = len(self.tf.messages)
            answer = spawn(MODELS / f"{model}.model.yaml", "robot", "ns")

            self.assertFalse(answer.success)
            self.assertIn(reason, answer.message)
            self.assertEqual(ServerTopics.ask(), before)
            self.clock.next(20)
            frames = {t.child_frame_id for m in self.tf.messages[begin:] for t in m.transforms}
            self.assertIn("base_link", frames)
            self.assertEqual([frame for frame in frames if frame.startswith("ns")], [])
            gone = delete("robot")
            self.assertEqual(
                (gone.success, gone.message), (False, 'ModelError: there is no model "robot"')
            )

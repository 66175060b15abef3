#!/usr/bin/python3
"""Dragging, turning and deleting models by interactive markers, with feedback as rviz sends it."""

import math
import sys
import tempfile
import unittest

import rospkg
import rospy
from flatland_msgs.msg import DebugTopicList, SimulationState
from flatland_msgs.srv import ChangeRate, GetModelMarkers, Step
from rostest_tools import Recorder
from service_calls import delete, spawn
from std_srvs.srv import Empty, Trigger
from visualization_msgs.msg import InteractiveMarkerFeedback as Feedback
from visualization_msgs.msg import InteractiveMarkerInit, InteractiveMarkerUpdate, MarkerArray
from waiting import wait_until

BOX = "box_1"
BOX_FILE = rospkg.RosPack().get_path("flatland_server") + "/worlds/office/box.model.yaml"


def handles():
    topic = "/interactive_model_markers/update_full"
    return rospy.wait_for_message(topic, InteractiveMarkerInit, 20).markers


class InteractiveMarkers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.state = Recorder("/flatland_server/state", SimulationState)
        cls.markers = Recorder(f"/flatland_server/debug/model/{BOX}", MarkerArray)
        cls.mouse = rospy.Publisher("/interactive_model_markers/feedback", Feedback, queue_size=100)
        for service in ("/resume", "/pause", "/change_rate", "/get_model_markers"):
            rospy.wait_for_service(service, 20)
        wait_until(cls.mouse.get_num_connections, "the server to subscribe to feedback")
        wait_until(lambda: BOX in [handle.name for handle in handles()], "the handles")
        cls.markers.next()

    def setUp(self):
        rospy.ServiceProxy("/resume", Empty)()
        self.wait_for_state(paused=False)

    def wait_for_state(self, paused, limit=20.0):
        wait_until(
            lambda: self.state.messages and self.state.messages[-1].paused == paused,
            f"paused: {paused}",
            limit,
        )

    def send(self, event, x=0.0, y=0.0, yaw=0.0, model=BOX, entry=0):
        feedback = Feedback(
            client_id="test", marker_name=model, event_type=event, menu_entry_id=entry
        )
        feedback.header.frame_id = "map"
        feedback.pose.position.x, feedback.pose.position.y = x, y
        feedback.pose.orientation.z = math.sin(yaw / 2)
        feedback.pose.orientation.w = math.cos(yaw / 2)
        self.mouse.publish(feedback)

    def wait_for_pose(self, x, y, yaw):
        def is_there():
            pose = self.markers.messages[-1].markers[0].pose
            found_yaw = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
            found = (pose.position.x, pose.position.y, found_yaw)
            return math.dist(found, (x, y, yaw)) < 0.001

        wait_until(is_there, f"{BOX} to be at {x}, {y}, {yaw}")

    def test_a_drag_moves_the_model_while_the_simulation_waits(self):
        updates = Recorder("/interactive_model_markers/update", InteractiveMarkerUpdate)
        updates.next()

        def places():
            """The x coordinates to which the handle was moved."""
            poses = [each for update in updates.messages for each in update.poses]
            return [each.pose.position.x for each in poses if each.name == BOX]

        begin = self.markers.messages[-1].markers[0].pose.position
        self.send(Feedback.MOUSE_DOWN, 6.0, -0.2, 0.3)
        self.wait_for_state(paused=True)
        dragged = (5.6, 5.1, 4.6)  # not where other tests drag to: their last pose may come late
        for x in dragged:
            self.send(Feedback.POSE_UPDATE, x, -0.2, 0.8)
            self.wait_for_pose(x, -0.2, 0.8)
        self.assertTrue(self.state.messages[-1].paused)
        # rviz would put the model back to a pose that comes during the drag, at its end.
        self.assertFalse({round(x, 3) for x in places()}.intersection(dragged))
        self.send(Feedback.MOUSE_UP, 4.0, -0.2, 1.0)
        self.wait_for_state(paused=False)
        self.wait_for_pose(4.0, -0.2, 1.0)
        wait_until(lambda: places() and abs(places()[-1] - 4.0) < 1e-6, "the handle to follow")
        self.state.next(holds=lambda state: state.undo == f"Move {BOX}")
        self.assertEqual(rospy.ServiceProxy("/undo", Trigger)().message, f"Undone: Move {BOX}")
        wait_until(lambda: places() and abs(places()[-1] - begin.x) < 1e-3, "it to be back")
        updates.close()

    def test_the_ring_is_around_the_footprints_of_a_model(self):
        shape = "[[0.2, -0.4], [0.2, 0.4], [-1.2, 0.4], [-1.2, -0.4]]"  # a forklift, from its wheel
        footprint = f"{{type: polygon, points: {shape}, density: 1}}"
        base = f"bodies: [{{name: base, footprints: [{footprint}]}}]"
        with tempfile.NamedTemporaryFile("w", suffix=".model.yaml") as file:
            file.write(base)
            file.flush()
            self.assertTrue(spawn(file.name, "forklift", "", 2.0, 3.0, math.pi / 2).success)
        self.addCleanup(delete, "forklift")
        [handle] = wait_until(
            lambda: [handle for handle in handles() if handle.name == "forklift"], "its handle"
        )
        self.assertAlmostEqual(handle.pose.position.x, 2.0)
        self.assertAlmostEqual(handle.pose.position.y, 2.5)
        self.assertAlmostEqual(handle.scale, 2.5 * math.hypot(0.7, 0.4), places=5)
        [drag, _] = handle.controls
        corners = [p.x + drag.markers[0].pose.position.x for p in drag.markers[0].points]
        self.assertAlmostEqual(max(corners), 0.7)

        for event in (Feedback.MOUSE_DOWN, Feedback.MOUSE_UP):  # turned about its middle
            self.send(event, 2.0, 2.5, 0.0, model="forklift")
        markers = Recorder("/flatland_server/debug/model/forklift", MarkerArray)
        self.addCleanup(markers.close)

        def has_turned():
            latest = [each for message in markers.messages[-1:] for each in message.markers]
            places = [(each.pose.position.x, each.pose.position.y) for each in latest]
            return places and math.dist(places[0], (2.5, 2.5)) < 1e-3

        wait_until(has_turned, "the forklift to turn")

    def test_a_new_subscriber_is_served_in_a_pause(self):
        rospy.ServiceProxy("/pause", Empty)()
        self.wait_for_state(paused=True)
        updates = Recorder("/interactive_model_markers/update", InteractiveMarkerUpdate)
        self.addCleanup(updates.close)
        updates.next(holds=lambda update: update.type == InteractiveMarkerUpdate.KEEP_ALIVE)

    def test_a_drag_in_a_pause_does_not_end_it(self):
        rospy.ServiceProxy("/pause", Empty)()
        self.wait_for_state(paused=True)
        self.send(Feedback.MOUSE_DOWN, 4.0, -0.2)
        self.send(Feedback.MOUSE_UP, 5.0, -0.2)
        self.wait_for_pose(5.0, -0.2, 0.0)
        after = len(self.state.messages)
        self.state.next(3)
        self.assertTrue(all(state.paused for state in self.state.messages[after:]))

    def test_a_pause_during_a_drag_outlasts_the_drag(self):
        self.send(Feedback.MOUSE_DOWN, 4.0, -0.2)
        self.wait_for_state(paused=True)
        answer = rospy.ServiceProxy("/step", Step)(steps=1)
        self.assertFalse(answer.success)
        self.assertIn("the simulation is not paused", answer.message)
        rospy.ServiceProxy("/pause", Empty)()
        self.send(Feedback.MOUSE_UP, 5.0, -0.2)
        self.wait_for_pose(5.0, -0.2, 0.0)
        after = len(self.state.messages)
        self.state.next(3)
        self.assertTrue(all(state.paused for state in self.state.messages[after:]))

    def test_a_drag_without_feedback_ends_after_three_seconds(self):
        begin = rospy.get_rostime()
        self.send(Feedback.MOUSE_DOWN, 5.0, 0.0)
        self.wait_for_state(paused=True)
        self.wait_for_state(paused=False, limit=10.0)
        waited = (rospy.get_rostime() - begin).to_sec()
        self.assertGreater(waited, 2.8)
        self.assertLess(waited, 8.0)  # a busy machine may take its time

    def test_a_mouse_that_holds_still_does_not_end_the_drag(self):
        self.send(Feedback.MOUSE_DOWN, 5.0, 0.0)
        self.wait_for_state(paused=True)
        for _ in range(16):
            self.send(Feedback.KEEP_ALIVE, 5.0, 0.0)
            rospy.rostime.wallsleep(0.25)
        self.assertTrue(self.state.messages[-1].paused)
        self.send(Feedback.MOUSE_UP, 5.0, 0.0)
        self.wait_for_state(paused=False)

    def test_keep_alive_messages_are_sent_twice_a_simulated_second(self):
        updates = Recorder("/interactive_model_markers/update", InteractiveMarkerUpdate)

        def alive(update):
            return update.type == InteractiveMarkerUpdate.KEEP_ALIVE

        updates.next(holds=alive)
        begin, received = self.state.next().stamp, len(updates.messages)
        end = self.state.next(15).stamp
        count = len([update for update in updates.messages[received:] if alive(update)])
        self.assertAlmostEqual(count, 2.0 * (end - begin).to_sec(), delta=1.5)
        updates.close()

    def test_the_menu_deletes_a_model(self):
        topics = Recorder("/flatland_server/debug/topics", DebugTopicList)
        [handle] = [handle for handle in handles() if handle.name == "box_5"]
        [entry] = handle.menu_entries
        self.assertIn("Delete", entry.title)
        self.send(Feedback.MENU_SELECT, model="box_5", entry=entry.id)
        wait_until(
            lambda: topics.messages and "model/box_5" not in topics.messages[-1].topics,
            "box_5 to be deleted",
        )

    def test_the_rate_is_changed_and_an_invalid_one_refused(self):
        change = rospy.ServiceProxy("/change_rate", ChangeRate)
        self.assertTrue(change(0.5).success)
        wait_until(lambda: self.state.messages[-1].rate == 0.5, "the rate")
        answer = change(-1.0)
        self.assertFalse(answer.success)
        self.assertTrue(answer.message)
        self.assertTrue(change(1.0).success)
        wait_until(lambda: self.state.messages[-1].rate == 1.0, "the rate")

    def test_markers_of_a_model_file_are_returned_or_refused(self):
        ask = rospy.ServiceProxy("/get_model_markers", GetModelMarkers)
        answer = ask(BOX_FILE)
        self.assertTrue(answer.success, answer.message)
        self.assertTrue(answer.markers.markers)
        answer = ask("/nowhere/at_all.yaml")
        self.assertFalse(answer.success)
        self.assertIn("/nowhere/at_all.yaml", answer.message)


if __name__ == "__main__":
    import rostest

    rospy.init_node("interactive_markers_rostest", disable_rostime=True)
    rostest.rosrun("flatland_server", "interactive_markers", InteractiveMarkers, sys.argv)

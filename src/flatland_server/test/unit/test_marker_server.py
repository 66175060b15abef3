"""The interactive markers' server without the library's thread; the rest is in a rostest."""

import threading

import pytest
import rospy
from interactive_markers.interactive_marker_server import InteractiveMarkerServer, MarkerContext
from rospy import rostime
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback

from flatland_server.ros.rospy_patches.marker_server import MarkerServer

LIMIT = 10.0  # s


def test_no_thread_of_the_library_waits_for_the_next_step(monkeypatch):
    timers, calls = [], []

    def start_timer(_server, _topics):
        """Starts a thread that waits for simulated time, as the library does."""
        timers.append(rospy.Timer(rospy.Duration(0.5), calls.append))

    monkeypatch.setattr(rostime, "_rostime_initialized", True)
    monkeypatch.setattr(rostime, "_rostime_current", None)
    monkeypatch.setattr(InteractiveMarkerServer, "__init__", start_timer)
    monkeypatch.setattr(InteractiveMarkerServer, "__del__", lambda _: None)
    rostime._set_rostime(rospy.Time(1))
    other = rospy.Timer(rospy.Duration(1000.0), lambda _: None)

    MarkerServer("topics")
    for second in range(2, 10):
        rostime._set_rostime(rospy.Time(second))
    timers[0].join(LIMIT)

    assert not timers[0].is_alive()
    assert len(calls) == 0
    assert other.is_alive()
    other.shutdown()
    rostime._set_rostime(rospy.Time(2000))
    other.join(LIMIT)


@pytest.mark.parametrize(("is_allowed", "received"), [(False, 0), (True, 1)])
def test_a_drag_is_allowed_in_the_first_second_of_simulated_time(monkeypatch, is_allowed, received):
    monkeypatch.setattr(rostime, "_rostime_initialized", True)
    monkeypatch.setattr(rostime, "_rostime_current", rospy.Time.from_sec(0.3))
    monkeypatch.setattr(InteractiveMarkerServer, "__del__", lambda _: None)
    feedback = []
    marker = MarkerContext()
    marker.default_feedback_cb = feedback.append
    marker.last_feedback = rospy.Time.from_sec(0.1)  # when the library made it
    server = MarkerServer.__new__(MarkerServer)
    server.mutex, server.marker_contexts = threading.Lock(), {"box": marker}

    if is_allowed:
        server.allow_drag("box")
    server.processFeedback(InteractiveMarkerFeedback(marker_name="box", client_id="rviz"))

    assert len(feedback) == received


def test_a_pose_that_a_client_drags_to_is_not_sent_back_with_changes_of_other_markers(monkeypatch):
    monkeypatch.setattr(rostime, "_rostime_initialized", True)
    monkeypatch.setattr(rostime, "_rostime_current", rospy.Time(5))
    monkeypatch.setattr(InteractiveMarkerServer, "__del__", lambda _: None)
    server = MarkerServer.__new__(MarkerServer)
    server.mutex, server.marker_contexts, server.pending_updates = threading.Lock(), {}, {}
    server.seq_num, published = 0, []
    server.publish, server.publishInit = published.append, lambda: None
    for name in ("box", "robot"):
        server.insert(InteractiveMarker(name=name), lambda feedback: None)
    server.applyChanges()
    server.allow_drag("box")
    published.clear()

    feedback = InteractiveMarkerFeedback(marker_name="box", client_id="rviz")
    feedback.event_type = InteractiveMarkerFeedback.POSE_UPDATE
    feedback.pose.position.x = 5.5
    server.processFeedback(feedback)
    moved = InteractiveMarker().pose
    moved.position.x = 1.0
    assert server.setPose("robot", moved)
    server.applyChanges()

    [update] = published
    assert [(each.name, each.pose.position.x) for each in update.poses] == [("robot", 1.0)]

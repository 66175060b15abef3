"""What the library for interactive markers is kept from doing; the rest is in a rostest."""

import rospy
from rospy import rostime

from flatland_server.ros import interactive_marker_manager
from flatland_server.ros.interactive_marker_manager import _LONG_AGO, _server_without_timer

LIMIT = 10.0  # s


class LibrarysServer:
    """Starts a thread that waits for simulated time, as the library's does."""

    def __init__(self, _topics: str) -> None:
        self.calls = 0
        self.timer = rospy.Timer(rospy.Duration(0.5), self._count)

    def _count(self, _event: object) -> None:
        self.calls += 1


def test_no_thread_of_the_library_waits_for_the_next_step(monkeypatch):
    monkeypatch.setattr(rostime, "_rostime_initialized", True)
    monkeypatch.setattr(rostime, "_rostime_current", None)
    monkeypatch.setattr(interactive_marker_manager, "InteractiveMarkerServer", LibrarysServer)
    rostime._set_rostime(rospy.Time(1))
    others = rospy.Timer(rospy.Duration(1000.0), lambda _: None)

    server = _server_without_timer("topics")
    for second in range(2, 10):
        rostime._set_rostime(rospy.Time(second))
    server.timer.join(LIMIT)

    assert not server.timer.is_alive()
    assert server.calls == 0
    assert others.is_alive()
    others.shutdown()
    rostime._set_rostime(rospy.Time(2000))
    others.join(LIMIT)


def test_a_marker_can_be_dragged_in_the_first_second_of_a_simulation():
    """The library refuses another client's feedback if the last was less than a second ago."""
    assert (rospy.Time(0) - _LONG_AGO).to_sec() >= 1.0

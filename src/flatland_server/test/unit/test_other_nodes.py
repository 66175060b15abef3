"""Warnings of other nodes that publish on a plugin's topic or place the server's frames."""

from types import SimpleNamespace
from typing import Any, ClassVar, Dict, List

import pytest
import rospy
from geometry_msgs.msg import TransformStamped
from logged import warnings
from tf2_msgs.msg import TFMessage

from flatland_server.ros import other_nodes
from flatland_server.ros.other_nodes import OtherLocalisers, OtherPublishers

BESIDE_AMCL = [["/tf", ["/server", "/amcl"]], ["/scan", ["/server"]]]


class Subscriber:
    """A fake of rospy's: `open` has the callbacks by topic."""

    open: ClassVar = {}

    def __init__(self, topic, _type, callback):
        self._topic = topic
        self.open[topic] = callback

    def unregister(self):
        del self.open[self._topic]


@pytest.fixture
def watch(monkeypatch):
    """A watch of odom and r1_odom on /tf and of odom on /r2/tf, and the real time that it sees."""
    monkeypatch.setattr(rospy, "get_name", lambda: "/server")
    monkeypatch.setattr(rospy, "Subscriber", Subscriber)
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(other_nodes, "time", SimpleNamespace(monotonic=lambda: clock.now))
    yield OtherLocalisers(lambda: {("", "odom"), ("", "r1_odom"), ("r2", "odom")}), clock
    Subscriber.open.clear()


def send(node, child, topic="/tf"):
    transform = TransformStamped(child_frame_id=child)
    message = TFMessage([transform])
    message._connection_header = {"callerid": node}
    Subscriber.open[topic](message)


@pytest.mark.parametrize("topic", ["/tf", "/tf_static"])
def test_a_localiser_beside_map_to_odom_is_named_once(watch, caplog, topic):
    watch[0].follow(BESIDE_AMCL)

    for node, child in (("/server", "odom"), ("/amcl", "base_link"), *2 * [("/amcl", "/r1_odom")]):
        send(node, child, topic)

    [warning] = warnings(caplog)
    assert warning.startswith('both /amcl and the server place the frame "r1_odom": start server.')
    assert "map_to_odom:=false" in warning


def test_frames_of_one_name_in_two_namespaces_are_two(watch, caplog):
    watch[0].follow([["/r2/tf", ["/server", "/r2/amcl"]]])

    send("/r2/amcl", "r1_odom", "/r2/tf")
    assert warnings(caplog) == []
    send("/r2/amcl", "odom", "/r2/tf_static")

    [warning] = warnings(caplog)
    assert warning.startswith('both /r2/amcl and the server place the frame "odom"')


def test_transforms_are_received_only_while_a_node_is_new(watch, caplog):
    others, clock = watch
    others.follow([["/tf", ["/server"]]])
    assert not Subscriber.open

    others.follow(BESIDE_AMCL)
    assert set(Subscriber.open) == {"/tf", "/tf_static", "/r2/tf", "/r2/tf_static"}

    clock.now = 61.0
    others.follow(BESIDE_AMCL)
    assert not Subscriber.open
    others.follow([["/tf", ["/server", "/amcl", "/gmapping"]]])
    assert Subscriber.open


# Publishers on a plugin's topic


class Master:
    """A fake of the master: its publishers by topic, or None while it does not answer."""

    state: Any

    def publishers(self) -> List[Any]:
        if self.state is None:
            raise ConnectionError
        return [[topic, nodes] for topic, nodes in self.state.items()]


@pytest.fixture
def check(monkeypatch, caplog):
    """Looks at the publishers of two topics, and returns the warnings."""
    master = Master()
    monkeypatch.setattr(rospy, "get_name", lambda: "/server")
    others = OtherPublishers({"/odometry/filtered": 1, "/deleted": 0, "/r1/tf": 1}, master)

    def look(state: Dict[str, List[str]]) -> List[str]:
        caplog.clear()
        master.state = state
        others.check()
        return warnings(caplog)

    return look


def test_a_second_publisher_is_named_once(check):
    both = {"/odometry/filtered": ["/server", "/ekf"]}

    [warning] = check(both)

    assert warning.startswith("/odometry/filtered is also published by /ekf: ")
    assert check(both) == []
    assert check({"/odometry/filtered": ["/server"]}) == []
    assert len(check(both)) == 1  # once more for one that comes back


def test_topics_that_only_others_publish_cause_no_warning(check):
    assert check({"/map": ["/map_server"], "/deleted": ["/ekf"], "/tf": ["/server", "/amcl"]}) == []


def test_transforms_have_several_publishers(check):
    assert check({"/r1/tf": ["/server", "/r1/amcl"]}) == []


def test_a_master_that_does_not_answer_is_asked_again(check):
    assert check(None) == []
    assert len(check({"/odometry/filtered": ["/ekf"]})) == 1

"""Waiting for callbacks, and running functions on the simulation's thread, without a master."""

import sys
import threading

import pytest
import rospy
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from flatland_server.exceptions import TopicError
from flatland_server.geometry import Pose, Transform
from flatland_server.ros.ros_transport import RosTransport
from flatland_server.ros.rospy_patches import RospyCalls
from flatland_server.ros.rospy_patches.rospy_calls import Outbox
from flatland_server.transport.node import Node


def test_a_signal_may_end_it_at_any_point():
    """Python runs signal handlers where it calls functions; a profiler runs there too."""
    transport = RosTransport()
    transport.post(lambda: None)
    interrupted = set()

    def interrupt(frame, _event, _argument):
        interrupted.add(frame.f_code.co_name)
        transport.end()
        transport.is_ending = False  # interrupt it again later

    def simulate():
        sys.setprofile(interrupt)
        transport.process(0.001)
        sys.setprofile(None)

    simulation = threading.Thread(target=simulate, daemon=True)
    simulation.start()
    simulation.join(10)

    assert not simulation.is_alive()
    assert {"process", "wait", "clear", "_is_owned"} <= interrupted


def test_after_its_end_it_does_not_wait():
    transport = RosTransport()
    transport.end()

    simulation = threading.Thread(target=transport.process, args=(60.0,), daemon=True)
    simulation.start()
    simulation.join(10)

    assert not simulation.is_alive()


@pytest.fixture
def simulating():
    """A transport that a thread processes until the test ends."""
    transport = RosTransport()

    def simulate():
        while not transport.is_ending:
            transport.process(0.01)

    simulation = threading.Thread(target=simulate, name="simulation", daemon=True)
    simulation.start()
    yield transport
    transport.end()
    simulation.join(10)


def test_a_function_is_run_on_the_simulations_thread(simulating):
    assert simulating.call(lambda: threading.current_thread().name) == "simulation"


@pytest.mark.parametrize("error", [ValueError("no"), TimeoutError("no answer"), SystemExit(3)])
def test_an_exception_is_raised_for_the_caller(simulating, error):
    def fail():
        raise error

    with pytest.raises(type(error)) as caught:
        simulating.call(fail)

    assert caught.value is error
    assert simulating.call(lambda: "still running") == "still running"


def test_a_call_is_refused_when_the_simulation_ends():
    transport = RosTransport()
    transport.end()

    with pytest.raises(rospy.ServiceException, match="shutting down"):
        transport.call(lambda: None)


def test_the_publishers_of_a_topic_count_its_subscribers_once():
    """A reset opens a topic again before the former publisher is closed."""
    transport = RosTransport()
    options = {"latch": False, "queue_size": 1}
    first = transport.advertise("counted", String, **options)
    for _ in range(3):
        second = transport.advertise("counted", String, **options)
        first.close()
        first = second

    assert len(first._publisher.impl.subscriber_listeners) == 1
    first.close()
    again = transport.advertise("counted", String, **options)
    assert len(again._publisher.impl.subscriber_listeners) == 1
    again.close()


def test_topics_are_compared_as_rospy_resolves_them(monkeypatch):
    remapped = {"scan": "/clock"}  # as by scan:=/clock on the command line
    monkeypatch.setattr(rospy, "resolve_name", lambda name: remapped.get(name, f"/{name}"))
    node = Node(RosTransport(), "", "robot/laser")

    with pytest.raises(TopicError, match='the topic "/clock" is the server\'s own'):
        node.advertise("scan", LaserScan)


class RecordedOutbox(Outbox):
    """Notes when it is told to send."""

    def __init__(self) -> None:
        self.events = []
        self.can_hold, self.is_due, self.is_empty = True, lambda: False, lambda: True

    def send(self) -> None:
        self.events.append("outbox")


@pytest.fixture
def holding():
    """A transport that has sent a transform in a step in which messages may be held back."""
    outbox = RecordedOutbox()
    events = outbox.events
    transport = RosTransport(
        RospyCalls(outbox=outbox, send_framed=lambda _, data: events.append("message"))
    )
    transport.before_sending = lambda: events.append("clock")
    transport.process(0.0)
    transport.send_transform(Transform(7, "map", "odom", Pose()))
    transport.events, transport.outbox = events, outbox
    return transport


def test_messages_after_the_first_flush_are_not_held_back(holding):
    holding.flush()
    assert holding.events == ["message"]

    holding.send_transform(Transform(7, "map", "odom", Pose()))
    holding.flush()
    assert holding.events == ["message", "clock", "message"]


def test_messages_are_sent_at_the_end_of_a_step_if_they_are_due(holding):
    holding.outbox.is_due = lambda: True

    holding.flush()

    assert holding.events == ["message", "clock", "outbox"]


def test_waiting_messages_are_sent_at_the_end_of_the_last_step(holding):
    holding.outbox.is_open = False
    holding.flush()
    assert holding.events == ["clock", "message"]

    holding.outbox.is_empty = lambda: False
    holding.flush()
    assert holding.events == ["clock", "message", "clock", "outbox"]


def test_messages_are_sent_before_a_wait(holding):
    holding.flush()

    holding.process(0.001)

    assert holding.events[:3] == ["message", "clock", "outbox"]


def test_messages_are_sent_before_callbacks(holding):
    holding.flush()
    holding.post(lambda: holding.events.append("callback"))

    holding.process(0.0)

    assert holding.events == ["message", "clock", "outbox", "callback"]

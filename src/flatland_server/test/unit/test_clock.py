"""Simulated time as it is told to others, without a master: what leaves, in which order."""

import struct
from typing import Any, ClassVar, List, Tuple

import pytest
import rospy

from flatland_server.geometry import Pose, Transform
from flatland_server.ros import clock as clock_module
from flatland_server.ros import ros_transport
from flatland_server.ros.clock import ClockPublisher
from flatland_server.ros.ros_transport import RosTransport
from flatland_server.timekeeper import Timekeeper

STEP = 5_000_000  # ns


class Publisher:
    """Stands in for rospy's."""

    sent: ClassVar[List[Tuple[str, Any]]] = []

    def __init__(self, topic: str, *_: Any, **__: Any) -> None:
        self.topic = topic

    def get_num_connections(self) -> int:
        return 1

    def publish(self, message: Any) -> None:
        self.sent.append((self.topic, message))


class Writer:
    """Makes a value of its own bytes."""

    def data(self, value: bytes) -> bytes:
        return value


@pytest.fixture
def sent(monkeypatch) -> List[Tuple[str, Any]]:
    """What has left this process: topics and messages; /clock's as they go over the wire."""
    sent: List[Tuple[str, Any]] = []
    monkeypatch.setattr(Publisher, "sent", sent)
    monkeypatch.setattr(rospy, "Publisher", Publisher)
    for module, name in ((clock_module, "send_framed"), (ros_transport, "send_bytes")):
        monkeypatch.setattr(module, name, lambda to, data: sent.append((to.topic, data)))
    return sent


@pytest.fixture
def make_clock(sent, monkeypatch):
    """Makes a clock of a timekeeper that is at 0, and forgets that it has said so."""

    def make(timekeeper: Timekeeper, uses_simulated_time: bool = False) -> ClockPublisher:
        simtime = clock_module.simtime
        monkeypatch.setattr(simtime, "_is_use_simtime", lambda: uses_simulated_time)
        monkeypatch.setattr(simtime, "_clock_sub", Publisher("/clock"), raising=False)
        monkeypatch.setattr(Publisher, "unregister", lambda _: None, raising=False)
        clock = ClockPublisher(timekeeper)
        assert ticks(sent) == [0]
        sent.clear()
        return clock

    return make


def ticks(sent: List[Tuple[str, Any]]) -> List[int]:
    """The times of all messages of /clock [ns]."""
    data = b"".join(message for topic, message in sent if topic == "/clock")
    messages = list(struct.iter_unpack("<III", data))
    assert all(length == 8 for length, _, _ in messages)
    return [seconds * 1_000_000_000 + nanoseconds for _, seconds, nanoseconds in messages]


def make_step(timekeeper: Timekeeper, clock: ClockPublisher) -> None:
    timekeeper.step()
    clock.tick()


def test_ticks_leave_together_each_a_message_of_its_own(sent, make_clock):
    timekeeper = Timekeeper(STEP * 1e-9)
    clock = make_clock(timekeeper)

    for _ in range(49):
        make_step(timekeeper, clock)
    assert sent == []
    clock.flush()
    clock.flush()

    assert len(sent) == 1
    assert ticks(sent) == [STEP * (i + 1) for i in range(49)]


def test_no_more_ticks_leave_together_than_a_queue_of_100_holds(sent, make_clock):
    timekeeper = Timekeeper(STEP * 1e-9)
    clock = make_clock(timekeeper)

    for _ in range(300):
        make_step(timekeeper, clock)

    assert len(sent) == 6
    assert ticks(sent) == [STEP * (i + 1) for i in range(300)]


def test_this_process_knows_the_time_of_each_step_at_once(make_clock, monkeypatch):
    monkeypatch.setattr(rospy.rostime, "_rostime_current", None)
    monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
    timekeeper = Timekeeper(0.7)
    clock = make_clock(timekeeper, uses_simulated_time=True)

    times = []
    for _ in range(3):
        make_step(timekeeper, clock)
        times.append(rospy.Time.now())

    assert times == [
        rospy.Time(0, 700_000_000),
        rospy.Time(1, 400_000_000),
        rospy.Time(2, 100_000_000),
    ]


@pytest.mark.parametrize("kind", ["message", "bytes", "latched", "transform", "callback"])
def test_nothing_overtakes_the_clock(kind, sent, make_clock):
    timekeeper = Timekeeper(STEP * 1e-9)
    clock = make_clock(timekeeper)
    transport = RosTransport()
    transport.before_sending = clock.flush
    topic = transport.advertise("/topic", None, latch=kind == "latched", queue_size=1)
    make_step(timekeeper, clock)
    make_step(timekeeper, clock)

    if kind == "bytes":
        topic.write(Writer(), b"value")
    elif kind == "transform":
        transport.send_transform(Transform(STEP, "map", "odom", Pose(0.0, 0.0, 0.0)))
        transport.flush()
    elif kind == "callback":
        transport.post(lambda: sent.append(("an answer", None)))
        transport.process()
    else:
        topic.publish("value")

    assert len(sent) == 2
    assert ticks(sent[:1]) == [STEP, 2 * STEP]

"""/clock without a master: which messages are sent, and in which order."""

import struct
from typing import Any, ClassVar, Dict, List, Tuple

import pytest
import rospy

from flatland_server.geometry import Pose, Transform
from flatland_server.ros.clock import ClockPublisher
from flatland_server.ros.ros_transport import RosTransport
from flatland_server.ros.rospy_patches import RospyCalls, local_time
from flatland_server.timekeeper import Timekeeper

STEP = 5_000_000  # ns


class Publisher:
    """A fake of rospy's."""

    sent: ClassVar[List[Tuple[str, Any]]] = []
    listeners: ClassVar[Dict[str, Any]] = {}  # by topic, to be notified of subscribers

    def __init__(self, topic: str, _: Any, listener: Any = None, **__: Any) -> None:
        self.topic = topic
        self.listeners[topic] = listener

    def get_num_connections(self) -> int:
        return 1

    def publish(self, message: Any) -> None:
        self.sent.append((self.topic, message))


class Writer:
    """Serializes bytes as themselves."""

    def data(self, value: bytes) -> bytes:
        return value


@pytest.fixture
def sent(monkeypatch) -> List[Tuple[str, Any]]:
    """The topics and messages sent by this process; those of /clock as on a TCPROS connection."""
    sent: List[Tuple[str, Any]] = []
    monkeypatch.setattr(Publisher, "sent", sent)
    monkeypatch.setattr(rospy, "Publisher", Publisher)
    return sent


@pytest.fixture
def rospy_calls(sent) -> RospyCalls:
    """The operations of rospy, which note what is sent."""

    def send(publisher: Publisher, data: bytes) -> None:
        sent.append((publisher.topic, data))

    return RospyCalls(send_framed=send, take_over_time=local_time.take_over_time)


@pytest.fixture
def make_clock(sent, rospy_calls, monkeypatch):
    """Makes a timekeeper at 0 and a clock of it, and discards its first tick."""

    def make(step: float = STEP * 1e-9, uses_simulated_time: bool = False) -> Any:
        timekeeper = Timekeeper(step)
        subscription = Publisher("/clock", None) if uses_simulated_time else None
        monkeypatch.setattr(local_time.simtime, "_clock_sub", subscription, raising=False)
        monkeypatch.setattr(Publisher, "unregister", lambda _: None, raising=False)
        clock = ClockPublisher(timekeeper, rospy_calls)
        assert ticks(sent) == [0]
        sent.clear()
        return timekeeper, clock

    return make


def ticks(sent: List[Tuple[str, Any]]) -> List[int]:
    """The times of all messages on /clock [ns]."""
    data = b"".join(message for topic, message in sent if topic == "/clock")
    messages = list(struct.iter_unpack("<III", data))
    assert all(length == 8 for length, _, _ in messages)
    return [seconds * 1_000_000_000 + nanoseconds for _, seconds, nanoseconds in messages]


def make_step(timekeeper: Timekeeper, clock: ClockPublisher) -> None:
    timekeeper.step()
    clock.tick()


def test_ticks_are_sent_together_each_as_a_message_of_its_own(sent, make_clock):
    timekeeper, clock = make_clock()

    for _ in range(49):
        make_step(timekeeper, clock)
    assert sent == []
    clock.flush()
    clock.flush()

    assert len(sent) == 1
    assert ticks(sent) == [STEP * (i + 1) for i in range(49)]


def test_no_more_than_a_queue_of_100_ticks_is_sent_at_once(sent, make_clock):
    timekeeper, clock = make_clock()

    for _ in range(300):
        make_step(timekeeper, clock)

    assert len(sent) == 6
    assert ticks(sent) == [STEP * (i + 1) for i in range(300)]


def test_a_subscriber_that_comes_in_a_pause_gets_the_time(sent, make_clock):
    timekeeper, clock = make_clock()
    make_step(timekeeper, clock)
    clock.flush()

    Publisher.listeners["/clock"].peer_subscribe("/clock", None, None)
    for _ in range(3):
        clock.repeat_for_new_subscribers()

    assert ticks(sent) == [STEP, STEP]


def test_this_process_knows_the_time_of_each_step_at_once(make_clock, monkeypatch):
    monkeypatch.setattr(rospy.rostime, "_rostime_current", None)
    monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
    timekeeper, clock = make_clock(0.7, uses_simulated_time=True)

    times = []
    for _ in range(3):
        make_step(timekeeper, clock)
        times.append(rospy.Time.now().to_nsec())

    assert times == [700_000_000, 1_400_000_000, 2_100_000_000]


@pytest.mark.parametrize("kind", ["message", "bytes", "latched", "transform", "callback"])
def test_nothing_overtakes_the_clock(kind, sent, make_clock, rospy_calls):
    timekeeper, clock = make_clock()
    transport = RosTransport(rospy_calls)
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

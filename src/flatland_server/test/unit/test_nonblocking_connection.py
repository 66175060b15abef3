"""Sending to subscribers: at once if they keep up, and never blocking if they do not."""

import socket
import struct
import time
from types import SimpleNamespace
from typing import List

import pytest
import rospy
from rospy.exceptions import TransportTerminated

from flatland_server import _core
from flatland_server.ros.rospy_patches import nonblocking_connection
from flatland_server.ros.rospy_patches.nonblocking_connection import (
    MOST,
    HeldMessages,
    NonblockingConnection,
    send_framed,
)

LIMIT = 10.0  # s
MESSAGES = [bytes([i]) * 9000 for i in range(200)]


class Transport:
    """The publisher's end of a socket, in place of rospy's TCPROSTransport."""

    def __init__(self, end: socket.socket) -> None:
        self.socket = end
        self.done = False
        self._cleanup = None

    def set_cleanup_callback(self, callback) -> None:
        self._cleanup = callback

    def close(self) -> None:
        self.done = True
        self.socket.close()
        self._cleanup(self)


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    monkeypatch.setattr(nonblocking_connection, "PATIENCE", 0.0)


@pytest.fixture
def subscriber():
    """A subscriber's socket, and the connection to it."""
    ours, theirs = socket.socketpair()
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 20_000)
    transport = Transport(ours)
    yield theirs, transport, NonblockingConnection(transport, 3)
    if not transport.done:
        transport.close()
    theirs.close()


def receive(end: socket.socket, count: int) -> bytes:
    end.settimeout(LIMIT)
    received = b""
    while len(received) < count:
        received += end.recv(count - len(received))
    return received


def receive_numbers(end: socket.socket, last: bytes) -> List[int]:
    """The first bytes of the messages up to the last one: whole ones, in their order."""
    got: List[bytes] = []
    while not got or got[-1] != last:
        got.append(receive(end, 9000))
    numbers = [message[0] for message in got]
    assert all(message == bytes([message[0]]) * 9000 for message in got)
    assert numbers == sorted(set(numbers))
    return numbers


def test_the_publishing_thread_sends_to_a_reading_subscriber(subscriber):
    theirs, _, connection = subscriber

    for i in range(100):
        connection.write_data(b"message %03d" % i)
        assert waiting(theirs) == b"message %03d" % i

    assert connection.stat_num_msg == 100


def test_a_stalled_subscriber_loses_whole_messages(subscriber):
    theirs, _, connection = subscriber

    begin = time.monotonic()
    for message in MESSAGES:
        connection.write_data(message)
    assert time.monotonic() - begin < LIMIT

    assert len(receive_numbers(theirs, MESSAGES[-1])) < len(MESSAGES)


def test_messages_that_have_not_waited_for_long_are_not_lost(subscriber, monkeypatch):
    theirs, transport, _ = subscriber
    monkeypatch.setattr(nonblocking_connection, "PATIENCE", 1000.0)
    connection = NonblockingConnection(transport, 3)

    for message in MESSAGES:
        connection.write_data(message)

    assert receive_numbers(theirs, MESSAGES[-1]) == list(range(200))


def test_a_message_larger_than_the_socket_arrives_whole(subscriber):
    theirs, _, connection = subscriber
    large = bytes(range(256)) * 4000

    connection.write_data(large)
    connection.write_data(b"after")

    assert receive(theirs, len(large)) == large
    assert receive(theirs, 5) == b"after"
    assert (connection.stat_num_msg, connection.stat_bytes) == (2, len(large) + 5)


def test_a_closed_connection_is_reported(subscriber):
    theirs, transport, connection = subscriber
    theirs.close()

    with pytest.raises(TransportTerminated):
        connection.write_data(b"hello")

    assert transport.done


@pytest.fixture
def outbox(monkeypatch):
    """An open outbox in which messages may wait for a long time."""
    return opened(HeldMessages(1000.0), monkeypatch)


def opened(outbox: HeldMessages, monkeypatch) -> HeldMessages:
    monkeypatch.setattr(nonblocking_connection, "outbox", outbox)
    outbox.is_open = True
    return outbox


def waiting(end: socket.socket) -> bytes:
    """All that a subscriber can receive now."""
    end.setblocking(False)
    try:
        return end.recv(1_000_000)
    except BlockingIOError:
        return b""


def test_held_back_messages_are_sent_in_order_in_one_call(outbox):
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)  # a packet is a call
    transport = Transport(ours)
    connection = NonblockingConnection(transport, 3)

    for message in (b"one", b"two", b"three"):
        connection.write_data(message)
    assert waiting(theirs) == b""
    outbox.send()

    assert waiting(theirs) == b"onetwothree"
    assert (connection.stat_num_msg, connection.stat_bytes) == (3, 11)
    outbox.send()
    assert waiting(theirs) == b""
    transport.close()
    theirs.close()


def test_a_message_that_may_not_wait_comes_after_those_that_do(subscriber, outbox):
    theirs, _, connection = subscriber
    connection.write_data(b"held")

    outbox.is_open = False
    connection.write_data(b"now")

    assert waiting(theirs) == b"heldnow"
    outbox.send()
    assert waiting(theirs) == b""


@pytest.mark.parametrize(("hold_time", "count"), [(0.0, 1), (1000.0, MOST)])
def test_messages_are_due_after_a_time_or_if_there_are_many(
    subscriber, monkeypatch, hold_time, count
):
    _, _, connection = subscriber
    outbox = opened(HeldMessages(hold_time), monkeypatch)
    for _ in range(count):
        assert not outbox.is_due()
        connection.write_data(b"message")
    assert outbox.is_due()
    outbox.send()
    assert not outbox.is_due()


def test_a_full_queue_loses_whole_messages(subscriber, outbox):
    theirs, _, connection = subscriber
    messages = MESSAGES[:100]

    for begin in range(0, 100, 10):
        for message in messages[begin : begin + 10]:
            connection.write_data(message)
        outbox.send()

    numbers = receive_numbers(theirs, messages[-1])
    assert numbers[-3:] == [97, 98, 99]  # the queue has room for three
    assert len(numbers) < 30


def test_the_next_message_reports_a_closed_connection(subscriber, outbox):
    theirs, transport, connection = subscriber
    theirs.close()
    connection.write_data(b"hello")

    outbox.send()

    with pytest.raises(TransportTerminated):
        connection.write_data(b"hello")
    assert transport.done


class Topic:
    """A publisher's topic, in place of rospy's."""

    closed = False

    def __init__(self, connections) -> None:
        self.connections = connections

    def remove_connection(self, connection) -> None:
        self.connections = [each for each in self.connections if each is not connection]


def test_step_messages_reach_subscribers_until_they_disconnect(subscriber, outbox, monkeypatch):
    theirs, transport, connection = subscriber
    publisher = SimpleNamespace(impl=Topic([connection]))
    topics = SimpleNamespace(pubs={"/odom": publisher.impl})
    monkeypatch.setattr(rospy.topics, "get_topic_manager", lambda: topics)
    body = _core.World().add_body("dynamic", (0, 0, 0))
    message = _core.BodyMessage(bytes(12), _core.RelativePoses(None, [body]), [(0, None, None)])
    messages = _core.StepMessages()
    messages.add(1, outbox.step_message(publisher, message))

    messages.write(2_000_000_003)
    outbox.send()
    assert struct.unpack("<4I", waiting(theirs)) == (12, 1, 2, 3)  # length, header

    theirs.close()
    messages.write(4)
    outbox.send()
    assert publisher.impl.connections == []
    assert transport.done


def test_topics_with_unknown_connections_are_left_to_python(outbox):
    assert outbox.step_message(SimpleNamespace(impl=Topic([Broken()])), None) is None


class Broken:
    """A connection that cannot send."""

    is_closed = False

    def write_data(self, data: bytes) -> None:
        raise RuntimeError("no luck")

    def close(self) -> None:
        self.is_closed = True


def test_only_the_failing_connection_is_dropped(subscriber):
    theirs, _, connection = subscriber
    broken = Broken()
    publisher = SimpleNamespace(impl=Topic([broken, connection]))

    send_framed(publisher, b"\x05\0\0\0hello")

    assert receive(theirs, 9) == b"\x05\0\0\0hello"
    assert publisher.impl.connections == [connection]
    assert broken.is_closed

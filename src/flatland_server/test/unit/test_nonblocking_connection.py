"""Sending to subscribers: at once if they keep up, and never blocking if they do not."""

import socket
import threading
import time
from types import SimpleNamespace
from typing import List

import pytest
from rospy.exceptions import TransportTerminated

from flatland_server.ros.rospy_patches import nonblocking_connection
from flatland_server.ros.rospy_patches.nonblocking_connection import (
    MOST,
    PERIOD,
    HeldMessages,
    NonblockingConnection,
)
from flatland_server.ros.rospy_patches.raw_publishing import send_bytes

LIMIT = 10.0  # s


class Socket:
    """A socket that notes its calls, and the threads that make them."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self.calls = 0
        self.threads = set()

    def sendmsg(self, *arguments) -> int:
        self.calls += 1
        self.threads.add(threading.current_thread())
        return self._end.sendmsg(*arguments)

    def fileno(self) -> int:
        return self._end.fileno()

    def close(self) -> None:
        self._end.close()


class Transport:
    """The publisher's end of a socket, in place of rospy's TCPROSTransport."""

    def __init__(self, end: socket.socket) -> None:
        self.socket = Socket(end)
        self.done = False
        self.stat_bytes = self.stat_num_msg = 0
        self._cleanup = None

    def set_cleanup_callback(self, callback) -> None:
        self._cleanup = callback

    def close(self) -> None:
        self.done = True
        self.socket.close()
        self._cleanup(self)


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


def test_the_publishing_thread_itself_sends_to_a_subscriber_that_keeps_up(subscriber):
    theirs, transport, connection = subscriber

    for i in range(100):
        connection.write_data(b"message %03d" % i)
        assert receive(theirs, 11) == b"message %03d" % i

    assert transport.socket.threads == {threading.current_thread()}
    assert transport.stat_num_msg == 100


def test_a_subscriber_that_does_not_read_loses_whole_messages_and_blocks_nothing(subscriber):
    theirs, _, connection = subscriber
    messages = [bytes([i]) * 9000 for i in range(200)]

    begin = time.monotonic()
    for message in messages:
        connection.write_data(message)
    assert time.monotonic() - begin < LIMIT

    numbers = receive_numbers(theirs, messages[-1])
    assert len(numbers) < len(messages)


def test_a_message_larger_than_the_socket_arrives_whole(subscriber):
    theirs, transport, connection = subscriber
    large = bytes(range(256)) * 4000

    connection.write_data(large)
    connection.write_data(b"after")

    assert receive(theirs, len(large)) == large
    assert receive(theirs, 5) == b"after"
    with connection._lock:  # the thread has counted what it has sent
        assert (transport.stat_num_msg, transport.stat_bytes) == (2, len(large) + 5)


def test_a_closed_connection_is_reported(subscriber):
    theirs, transport, connection = subscriber
    theirs.close()

    with pytest.raises(TransportTerminated):
        connection.write_data(b"hello")

    assert transport.done


@pytest.fixture
def outbox(monkeypatch):
    """An open outbox, at a time that the test sets."""
    outbox = HeldMessages()
    outbox.now = 1000.0
    monkeypatch.setattr(nonblocking_connection, "outbox", outbox)
    monkeypatch.setattr(
        nonblocking_connection, "time", SimpleNamespace(monotonic=lambda: outbox.now)
    )
    outbox.open()
    return outbox


def waiting(end: socket.socket) -> bytes:
    """All that a subscriber can receive now."""
    end.setblocking(False)
    try:
        return end.recv(1_000_000)
    except BlockingIOError:
        return b""


def test_messages_that_are_held_back_are_sent_together_in_their_order(subscriber, outbox):
    theirs, transport, connection = subscriber

    for message in (b"one", b"two", b"three"):
        connection.write_data(message)
    assert waiting(theirs) == b""
    outbox.send()

    assert waiting(theirs) == b"onetwothree"
    assert transport.socket.calls == 1
    assert (transport.stat_num_msg, transport.stat_bytes) == (3, 11)
    outbox.send()
    assert transport.socket.calls == 1


def test_a_message_that_may_not_wait_comes_after_those_that_do(subscriber, outbox):
    theirs, _, connection = subscriber
    connection.write_data(b"held")

    outbox.is_open = False
    connection.write_data(b"now")

    assert waiting(theirs) == b"heldnow"
    outbox.send()
    assert waiting(theirs) == b""


def test_messages_are_due_after_a_time_from_the_first_one(subscriber, outbox):
    _, _, connection = subscriber
    assert not outbox.is_due

    connection.write_data(b"first")
    outbox.now += 0.9 * PERIOD
    connection.write_data(b"second")
    assert not outbox.is_due
    outbox.now += 0.2 * PERIOD
    assert outbox.is_due

    outbox.send()
    assert not outbox.is_due


def test_messages_are_due_if_a_connection_has_many(subscriber, outbox):
    _, _, connection = subscriber
    for _ in range(MOST - 1):
        connection.write_data(b"message")
    assert not outbox.is_due

    connection.write_data(b"message")
    assert outbox.is_due

    outbox.send()
    assert not outbox.is_due


def test_of_messages_sent_together_a_full_queue_loses_whole_ones(subscriber, outbox):
    theirs, _, connection = subscriber
    messages = [bytes([i]) * 9000 for i in range(100)]

    for begin in range(0, 100, 10):
        for message in messages[begin : begin + 10]:
            connection.write_data(message)
        outbox.send()

    numbers = receive_numbers(theirs, messages[-1])
    assert numbers[-3:] == [97, 98, 99]  # the queue has room for three
    assert len(numbers) < 30


def test_a_connection_found_closed_is_reported_by_the_next_message(subscriber, outbox):
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


class Broken:
    """A connection that cannot send."""

    is_closed = False

    def write_data(self, data: bytes) -> None:
        raise RuntimeError("no luck")

    def close(self) -> None:
        self.is_closed = True


def test_a_connection_that_fails_is_dropped_and_the_others_are_not(subscriber):
    theirs, _, connection = subscriber
    broken = Broken()
    publisher = SimpleNamespace(impl=Topic([broken, connection]))

    send_bytes(publisher, b"hello")

    assert receive(theirs, 9) == b"\x05\0\0\0hello"
    assert publisher.impl.connections == [connection]
    assert broken.is_closed

"""Sending to subscribers: at once if they keep up, and never blocking if they do not."""

import socket
import threading
import time
from types import SimpleNamespace

import pytest
from rospy.exceptions import TransportTerminated

from flatland_server.ros.rospy_patches.nonblocking_connection import NonblockingConnection
from flatland_server.ros.rospy_patches.raw_publishing import send_bytes

LIMIT = 10.0  # s


class Transport:
    """The publisher's end of a socket, in place of rospy's TCPROSTransport."""

    def __init__(self, end: socket.socket) -> None:
        self.socket = end
        self.done = False
        self.stat_bytes = self.stat_num_msg = 0
        self.threads = set()
        self._cleanup = None

    def set_cleanup_callback(self, callback) -> None:
        self._cleanup = callback

    def write_data(self, data: bytes) -> None:
        self.threads.add(threading.current_thread())
        self.socket.sendall(data)

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


def test_the_publishing_thread_itself_sends_to_a_subscriber_that_keeps_up(subscriber):
    theirs, transport, connection = subscriber

    for i in range(100):
        connection.write_data(b"message %03d" % i)
        assert receive(theirs, 11) == b"message %03d" % i

    assert transport.threads == set()
    assert transport.stat_num_msg == 100


def test_a_subscriber_that_does_not_read_loses_whole_messages_and_blocks_nothing(subscriber):
    theirs, _, connection = subscriber
    messages = [bytes([i]) * 9000 for i in range(200)]

    begin = time.monotonic()
    for message in messages:
        connection.write_data(message)
    assert time.monotonic() - begin < LIMIT

    got = []
    while not got or got[-1] != messages[-1]:
        got.append(receive(theirs, 9000))
    numbers = [message[0] for message in got]
    assert all(message == bytes([message[0]]) * 9000 for message in got)
    assert numbers == sorted(set(numbers))
    assert len(got) < len(messages)


def test_a_message_larger_than_the_socket_arrives_whole(subscriber):
    theirs, _, connection = subscriber
    large = bytes(range(256)) * 4000

    connection.write_data(large)
    connection.write_data(b"after")

    assert receive(theirs, len(large)) == large
    assert receive(theirs, 5) == b"after"


def test_a_closed_connection_is_reported(subscriber):
    theirs, transport, connection = subscriber
    theirs.close()

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

"""Sending to listeners: at once if they keep up, without ever waiting for those that do not."""

import socket
import threading
import time
from types import SimpleNamespace

import pytest
from rospy.exceptions import TransportTerminated

from flatland_server.ros.rospy_patches.nonblocking_connection import (
    NonblockingConnection,
    send_bytes,
)

LIMIT = 10.0  # s


class Transport:
    """The server's end of a socket, as rospy wraps it."""

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
def listener():
    """A listener's socket, and the connection to it."""
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


def test_a_listener_that_keeps_up_is_sent_to_by_the_publisher_itself(listener):
    theirs, transport, connection = listener

    for i in range(100):
        connection.write_data(b"message %03d" % i)
        assert receive(theirs, 11) == b"message %03d" % i

    assert transport.threads == set()
    assert transport.stat_num_msg == 100


def test_a_listener_that_does_not_read_loses_whole_messages_and_keeps_nobody_waiting(listener):
    theirs, _, connection = listener
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


def test_a_message_larger_than_the_socket_arrives_whole(listener):
    theirs, _, connection = listener
    large = bytes(range(256)) * 4000

    connection.write_data(large)
    connection.write_data(b"after")

    assert receive(theirs, len(large)) == large
    assert receive(theirs, 5) == b"after"


def test_a_listener_that_is_gone_is_said_to_be(listener):
    theirs, transport, connection = listener
    theirs.close()

    with pytest.raises(TransportTerminated):
        connection.write_data(b"hello")

    assert transport.done


class Topic:
    """What rospy knows of a publisher's topic."""

    closed = False

    def __init__(self, connections) -> None:
        self.connections = connections

    def remove_connection(self, connection) -> None:
        self.connections = [each for each in self.connections if each is not connection]


class Broken:
    """A connection over which nothing can be sent, for whatever reason."""

    is_closed = False

    def write_data(self, data: bytes) -> None:
        raise RuntimeError("no luck")

    def close(self) -> None:
        self.is_closed = True


def test_who_cannot_be_sent_to_is_left_out_and_the_others_are_not(listener):
    theirs, _, connection = listener
    broken = Broken()
    publisher = SimpleNamespace(impl=Topic([broken, connection]))

    send_bytes(publisher, b"hello")

    assert receive(theirs, 9) == b"\x05\0\0\0hello"
    assert publisher.impl.connections == [connection]
    assert broken.is_closed

"""Connections to rospy's socket: many at once, silent ones, and a lack of file descriptors."""

import errno
import os
import queue
import socket
import struct
import threading
from types import SimpleNamespace

import pytest
from rospy.impl import registration, tcpros_base

from flatland_server.ros.rospy_patches import install, tcpros_server
from flatland_server.ros.rospy_patches.tcpros_server import Handshakes

HEADER = struct.pack("<I", 11) + b"\x07\x00\x00\x00topic=/"
LIMIT = 10.0  # s


@pytest.fixture
def server(unpatched_rospy):
    """Rospy's server, with a socket of this test's; connections are not accepted."""
    return tcpros_base._tcpros_server.tcp_ros_server


def connection_pair():
    """The two ends of a TCP connection."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        ours = socket.create_connection(listening.getsockname(), LIMIT)
        return ours, listening.accept()[0]


def is_closed(connection):
    """Waits until the other side closes it; with a reset if it has not read everything."""
    try:
        return connection.recv(1) == b""
    except ConnectionResetError:
        return True


class Peers:
    """Connections that have yet to send their headers."""

    def __init__(self):
        self.complete = queue.Queue()
        self._handshakes = Handshakes(lambda *connection: self.complete.put(connection))

    def connect(self, name):
        ours, theirs = connection_pair()
        self._handshakes.add(theirs, name)
        return ours

    def next_complete(self):
        """The name of the next one to be passed on, and its header."""
        connection, name = self.complete.get(timeout=LIMIT)
        assert connection.getblocking()
        return name, connection.recv(4096)


@pytest.fixture
def peers():
    return Peers()


def test_a_hundred_connect_before_one_is_accepted(server):
    tcpros_server.install()

    address = server.server_sock.getsockname()
    subscribers = [socket.create_connection(address, 1.0) for _ in range(100)]

    for subscriber in subscribers:
        subscriber.close()


def test_another_rospy_is_left_as_it_is(unpatched_rospy, monkeypatch, caplog):
    monkeypatch.setattr(tcpros_base, "_tcpros_server", SimpleNamespace(start_server=lambda: None))

    install()

    assert "stops all services" in caplog.text


def test_a_connection_is_passed_on_when_its_header_is_complete(peers):
    silent = peers.connect("silent")
    slow = peers.connect("slow")
    slow.sendall(HEADER[:3])
    peers.connect("quick").sendall(HEADER + b"more")

    assert peers.next_complete() == ("quick", HEADER + b"more")
    slow.sendall(HEADER[3:9])
    assert peers.complete.empty()
    slow.sendall(HEADER[9:])
    assert peers.next_complete() == ("slow", HEADER)
    silent.sendall(HEADER)
    assert peers.next_complete() == ("silent", HEADER)


@pytest.mark.parametrize(
    "sent", [b"", HEADER[:2], HEADER[:-1]], ids=["nothing", "half a length", "half a header"]
)
def test_a_connection_that_ends_is_forgotten(peers, sent):
    ending = peers.connect("ending")
    ending.sendall(sent)
    ending.shutdown(socket.SHUT_WR)

    assert is_closed(ending)
    assert peers.complete.empty()


def test_too_large_a_header_is_refused(peers):
    greedy = peers.connect("greedy")
    greedy.sendall(struct.pack("<I", 1 << 30))

    assert is_closed(greedy)


def test_a_connection_that_sends_nothing_is_closed_in_time(monkeypatch, caplog):
    monkeypatch.setattr(tcpros_server, "HANDSHAKE_LIMIT", 0.05)
    peers = Peers()

    silent = [peers.connect("silent") for _ in range(3)]

    assert all(is_closed(connection) for connection in silent)
    peers.connect("other").sendall(HEADER)
    assert peers.next_complete() == ("other", HEADER)
    assert "sent no header within 0.05 s" in caplog.text


def test_a_failure_of_one_handshake_leaves_the_others(caplog):
    done = threading.Event()

    def handle(connection, name):
        if name == "bad":
            raise RuntimeError("what a header")
        done.set()

    handshakes = Handshakes(handle)
    for name in ("bad", "good"):
        ours, theirs = connection_pair()
        ours.sendall(HEADER)
        handshakes.add(theirs, name)

    assert done.wait(LIMIT)
    assert "what a header" in caplog.text


def test_accepting_goes_on_after_a_lack_of_file_descriptors(caplog, monkeypatch):
    monkeypatch.setattr(tcpros_server, "_RETRY_PERIOD", 0.0)
    failures = [OSError(errno.EMFILE, os.strerror(errno.EMFILE))] * 3

    class Listening:
        def accept(self):
            if failures:
                raise failures.pop()
            return "connection", "address"

    assert tcpros_server._PatientSocket(Listening()).accept() == ("connection", "address")
    assert caplog.text.count("Too many open files") == 1


@pytest.mark.parametrize("is_published", [False, True])
def test_a_late_subscriber_of_a_removed_topic_causes_no_warning(
    is_published, unpatched_rospy, monkeypatch, caplog
):
    publisher = SimpleNamespace(closed=False) if is_published else None
    manager = SimpleNamespace(get_publisher_impl=lambda topic: publisher)
    monkeypatch.setattr(registration, "get_topic_manager", lambda: manager)
    rospys = tcpros_base._tcpros_server
    passed_on = []
    rospys.topic_connection_handler = lambda *arguments: passed_on.append(arguments)
    install()
    ours, theirs = connection_pair()
    request = (theirs, "address", {"topic": "/r1/scan", "callerid": "/rviz"})

    assert rospys.topic_connection_handler(*request) is None
    if is_published:
        assert passed_on == [request]
    else:
        assert b"error=/r1/scan is not published" in ours.recv(4096)
        assert is_closed(ours)
    assert not [record for record in caplog.records if record.levelname != "DEBUG"]
    for connection in (ours, theirs):
        connection.close()

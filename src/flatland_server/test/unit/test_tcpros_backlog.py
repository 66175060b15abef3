"""Room for listeners who connect at once, in rospy's own socket."""

import socket
from types import SimpleNamespace

import pytest
from rospy.impl import tcpros_base

from flatland_server.ros.rospy_patches.tcpros_backlog import enlarge_tcpros_backlog


@pytest.fixture
def server(monkeypatch):
    """A socket that listens as rospy's does, in its place; nobody accepts."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen(5)
        rospys = SimpleNamespace(
            start_server=lambda: None, tcp_ros_server=SimpleNamespace(server_sock=server)
        )
        monkeypatch.setattr(tcpros_base, "_tcpros_server", rospys)
        yield server


def test_a_hundred_connect_before_anybody_is_let_in(server):
    enlarge_tcpros_backlog()

    listeners = [socket.create_connection(server.getsockname(), 1.0) for _ in range(100)]

    for listener in listeners:
        listener.close()


def test_a_rospy_that_is_another_inside_is_left_as_it_is(monkeypatch, caplog):
    monkeypatch.setattr(tcpros_base, "_tcpros_server", SimpleNamespace(start_server=lambda: None))

    enlarge_tcpros_backlog()

    assert "some will have to wait" in caplog.text

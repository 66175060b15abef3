"""Many subscribers that connect at once to rospy's socket."""

import socket
from types import SimpleNamespace

import pytest
from rospy.impl import tcpros_base

from flatland_server.ros.rospy_patches import install, tcpros_backlog


@pytest.fixture
def server(monkeypatch):
    """A socket in place of rospy's; connections are not accepted."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen(5)
        rospys = SimpleNamespace(
            start_server=lambda: None, tcp_ros_server=SimpleNamespace(server_sock=server)
        )
        monkeypatch.setattr(tcpros_base, "_tcpros_server", rospys)
        yield server


def test_a_hundred_connect_before_one_is_accepted(server):
    tcpros_backlog.install()

    subscribers = [socket.create_connection(server.getsockname(), 1.0) for _ in range(100)]

    for subscriber in subscribers:
        subscriber.close()


def test_another_rospy_is_left_as_it_is(unpatched_rospy, monkeypatch, caplog):
    monkeypatch.setattr(tcpros_base, "_tcpros_server", SimpleNamespace(start_server=lambda: None))

    install()

    assert "some are delayed" in caplog.text

"""Polls of topics: ended connections are found, in several threads at once."""

import socket
import threading

import pytest

from flatland_server.ros.rospy_patches.topic_polls import Poller


@pytest.fixture
def connection():
    pair = socket.socketpair()
    yield pair
    for end in pair:
        end.close()


def test_an_ended_connection_is_found(connection):
    near, far = connection
    poller = Poller()
    poller.add_fd(near.fileno())
    assert list(poller.error_iter()) == []

    far.close()

    assert list(poller.error_iter()) == [near.fileno()]


def test_a_descriptor_that_was_closed_is_forgotten(connection):
    poller = Poller()
    poller.add_fd(connection[0].fileno())
    connection[0].close()

    assert list(poller.error_iter()) == []
    assert list(poller.error_iter()) == []


def test_threads_may_poll_at_once(connection):
    """Threads of rospy do; an error ends the one that connects subscribers to publishers."""
    poller = Poller()
    poller.add_fd(connection[0].fileno())
    errors = []

    def poll():
        try:
            for _ in range(3000):
                list(poller.error_iter())
        except RuntimeError as error:
            errors.append(error)

    threads = [threading.Thread(target=poll) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert errors == []

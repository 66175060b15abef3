"""Ended connections of a topic are found without a file descriptor of the topic's own."""

import os
import socket
from concurrent.futures import ThreadPoolExecutor

import pytest

from flatland_server.ros.rospy_patches.topic_polls import Poller


@pytest.fixture
def pairs():
    pairs = [socket.socketpair() for _ in range(3)]
    yield pairs
    for pair in pairs:
        for end in pair:
            end.close()


@pytest.fixture
def poller(pairs):
    """Watches one end of each pair."""
    poller = Poller()
    for ours, _ in pairs:
        poller.add_fd(ours.fileno())
    return poller


def test_connections_that_have_ended_are_found(poller, pairs):
    assert list(poller.error_iter()) == []
    pairs[1][1].close()

    assert list(poller.error_iter()) == [pairs[1][0].fileno()]
    poller.remove_fd(pairs[1][0].fileno())
    assert list(poller.error_iter()) == []


def test_a_descriptor_that_was_closed_is_forgotten(poller, pairs):
    ours, theirs = pairs[0]
    number = ours.fileno()
    ours.close()
    assert list(poller.error_iter()) == []

    os.dup2(pairs[1][0].fileno(), number)  # another file with the same number
    theirs.close()
    pairs[1][1].close()

    assert list(poller.error_iter()) == [pairs[1][0].fileno()]
    os.close(number)


def test_several_threads_may_look_at_a_time(poller, pairs):
    pairs[2][1].close()
    expected = [pairs[2][0].fileno()]

    def look(_):
        return all(list(poller.error_iter()) == expected for _ in range(2000))

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(look, range(4)))

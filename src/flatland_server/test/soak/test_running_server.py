"""A running server under random calls and messages, and faults around it: a short soak."""

import random

import pytest
from running_server import Master, Server
from soak import faults, restarts
from soak.findings import Findings
from soak.random_calls import call_at_random
from soak.random_saves import save_at_random
from soak.ros_messages import publish_at_random

SEED = 1
CLIENTS, CALLS = 4, 60
MESSAGES = 40  # to each topic

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def server(master, tmp_path_factory):
    with restarts.ended(Server(master, tmp_path_factory.mktemp("soak") / "log")) as server:
        yield server


@pytest.fixture(scope="module")
def other_master():
    """For servers that are started and ended."""
    master = Master()
    yield master
    master.kill()


@pytest.fixture
def findings():
    """There must be none."""
    findings = Findings()
    yield findings
    assert findings.violations == []


def test_the_world_is_what_random_calls_have_made_of_it(server, master, findings):
    call_at_random(server, master, SEED, CLIENTS, CALLS, findings)

    assert findings.counts["calls"] == CLIENTS * CALLS


def test_a_saved_world_is_what_random_calls_have_made_of_it(server, tmp_path, findings):
    save_at_random(server, tmp_path / "saves", SEED, CALLS, findings)

    assert findings.counts["saved worlds"] > 1
    assert "Traceback" not in server.log


def test_random_messages_stop_nothing(server, master, findings):
    publish_at_random(server, master, SEED, MESSAGES, findings)

    assert findings.counts["messages over ROS"] >= 3 * MESSAGES


def test_subscribers_that_stop_reading_do_not_stop_time(server, findings):
    faults.stopped_subscribers(server, findings)


def test_silent_connections_are_not_noticed(server, findings):
    faults.silent_connections(server, random.Random(SEED), findings)


def test_the_server_outlives_a_lack_of_file_descriptors(server, findings):
    faults.no_descriptors(server, findings)

    assert "Traceback" not in server.log


def test_clients_go_on_with_a_server_that_was_killed_and_started(other_master, tmp_path, findings):
    restarts.killed_server(other_master, tmp_path, findings)


def test_a_server_runs_and_ends_without_a_disk_for_its_log(other_master, findings):
    restarts.full_disk(other_master, findings)


def test_a_signal_at_any_time_of_a_start_ends_it(other_master, tmp_path, findings):
    restarts.signals_at_random(other_master, tmp_path, random.Random(SEED), 2, findings)

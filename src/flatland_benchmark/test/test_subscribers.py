"""The real server with compiled listeners: all that is sent is heard, and none holds it up."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from ros_processes import processes_under

from flatland_benchmark.robot_worlds import write_world
from flatland_benchmark.server_process import ServerProcess
from flatland_server.exceptions import FlatlandError

WORLDS = Path(__file__).resolve().parents[2] / "flatland_server" / "worlds"
LASER, ODOMETRY, TF = "sensor_msgs/LaserScan", "nav_msgs/Odometry", "tf2_msgs/TFMessage"

BENCHMARK = """
import sys
from flatland_benchmark.server_process import ServerProcess

with ServerProcess(sys.argv[1]) as server:
    print(server.uri, flush=True)
    server.settle(60.0)
"""

pytestmark = pytest.mark.slow


@pytest.fixture
def server(tmp_path):
    """Two robots, five times as fast as real time."""
    world = write_world(tmp_path, WORLDS, 2)
    with ServerProcess(world, update_rate=1000) as server:
        yield server


def wait_until_gone(uri):
    """Waits until nothing runs under a ROS master."""
    deadline = time.monotonic() + 10
    while processes_under(uri):
        assert time.monotonic() < deadline, processes_under(uri)
        time.sleep(0.02)


def test_a_listener_hears_all_that_is_sent(server):
    listener = server.listen("listener", "--robots")
    listener.wait_until_connected()
    begin = listener.next_reading(after=listener.next_reading().real + 0.5)
    end = listener.next_reading(after=begin.real + 2.0)

    seconds = end.simulated - begin.simulated
    heard = {name: end.messages[name] - begin.messages[name] for name in end.messages}
    # The state overtakes what is on its way, or is overtaken by it: a few messages.
    assert seconds > 1.0
    assert heard[LASER] == pytest.approx(2 * 10 * seconds, abs=8)
    assert heard[ODOMETRY] == pytest.approx(2 * 200 * seconds, abs=40)
    assert heard[TF] == pytest.approx(200 * seconds, abs=20)


def test_a_listener_hears_topics_by_name_and_only_them(server):
    listener = server.listen("listener", "/robot_1/scan")
    listener.wait_until_connected()

    begin = listener.next_reading(after=listener.next_reading().real + 0.5)
    end = listener.next_reading(after=begin.real + 1.0)

    assert set(end.messages) == {LASER}
    seconds = end.simulated - begin.simulated
    assert end.messages[LASER] - begin.messages[LASER] == pytest.approx(10 * seconds, abs=4)


def test_without_being_asked_nobody_listens_to_clock(server):
    server.listen("listener", "--robots").wait_until_connected()

    assert server.listeners("/clock") == {"/rosout"}


def test_a_listener_to_a_hundred_robots_is_connected_in_seconds(tmp_path):
    with ServerProcess(write_world(tmp_path, WORLDS, 100)) as server:
        listener = server.listen("listener", "--robots")
        server.wait_until(
            lambda: listener.next_reading().is_connected, "a connection to each topic", limit=15.0
        )


def test_the_intervals_of_clock_are_those_of_steps(server):
    listener = server.listen("listener", "--clock")
    listener.next_reading(after=listener.next_reading().real + 1.0)

    clock = listener.end()

    assert clock["clock_intervals"] > 100
    assert clock["p50"] == pytest.approx(0.001, rel=0.5)
    assert clock["p50"] <= clock["p99"] <= clock["worst"]


def test_a_listener_that_is_stopped_does_not_hold_the_simulation_up(server):
    listener = server.listen("listener", "--robots")
    listener.wait_until_connected()
    before = server.measure(1.0)

    listener.process.stop()
    server.measure(2.0)  # fills its sockets
    memory = server.server.memory
    during = server.measure(3.0)
    grown = server.server.memory - memory
    listener.process.resume()

    assert during.times_real_time > 0.5 * before.times_real_time
    assert grown < 5.0  # MB: what is not read is dropped
    again = listener.next_reading()
    later = listener.next_reading(after=again.real + 1.0)
    assert later.messages[LASER] > again.messages[LASER]


def test_all_ends_with_the_server(tmp_path):
    with ServerProcess(write_world(tmp_path, WORLDS, 1)) as server:
        listener = server.listen("listener", "--robots")
        # master, rosout, server, two listeners, once rosrun has become them
        server.wait_until(lambda: len(processes_under(server.uri)) == 5, "all five to run")
        listener.process.stop()

    assert processes_under(server.uri) == []


def test_all_ends_with_a_benchmark_that_is_killed(tmp_path):
    world = write_world(tmp_path, WORLDS, 1)
    benchmark = subprocess.Popen(
        [sys.executable, "-c", BENCHMARK, str(world)],
        stdout=subprocess.PIPE,
        env={**os.environ, "TMPDIR": str(tmp_path)},
        text=True,
    )
    with benchmark.stdout as output:
        uri = output.readline().strip()
        assert len(processes_under(uri)) >= 4

        benchmark.kill()

        wait_until_gone(uri)
    benchmark.wait(10)


def test_a_server_that_fails_says_why(tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text("properties: {}\nlayers: []\nmodels: [{name: a}]\n")

    with pytest.raises(FlatlandError, match=r'(?s)flatland_server has ended.*"model" is missing'):
        ServerProcess(world).__enter__()

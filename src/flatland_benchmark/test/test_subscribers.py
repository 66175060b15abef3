"""The real server with compiled subscribers: all messages arrive, and none blocks the server."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from ros_processes import processes_under
from waiting import wait_until

from flatland_benchmark.robot_worlds import write_world
from flatland_benchmark.server_process import ServerProcess
from flatland_server.exceptions import FlatlandError

WORLDS = Path(__file__).resolve().parents[2] / "flatland_server" / "worlds"
LASER, ODOMETRY, TF = "sensor_msgs/LaserScan", "nav_msgs/Odometry", "tf2_msgs/TFMessage"

BENCHMARK = """
import sys
from flatland_benchmark.server_process import ServerProcess

with ServerProcess(sys.argv[1], update_rate=200) as server:
    print(server.uri, flush=True)
    server.settle(60.0)
"""

pytestmark = pytest.mark.slow


def wait_until_gone(uri):
    """Waits until nothing runs under a ROS master."""
    wait_until(lambda: not processes_under(uri), f"the end of all under {uri}")


def test_a_subscriber_to_a_hundred_robots_is_connected(tmp_path):
    with ServerProcess(write_world(tmp_path, WORLDS, 100)) as server:
        subscriber = server.subscribe("subscriber", "--robots")
        server.wait_until(
            lambda: subscriber.next_reading().is_connected, "a connection to each topic", limit=60.0
        )


def test_all_processes_end_with_the_server(tmp_path):
    with ServerProcess(write_world(tmp_path, WORLDS, 1), update_rate=200) as server:
        subscriber = server.subscribe("subscriber", "--robots")

        assert len(processes_under(server.uri)) == 5  # master, rosout, server, two subscribers
        subscriber.process.stop()

    assert processes_under(server.uri) == []


def test_all_processes_end_with_a_killed_benchmark(tmp_path):
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
    benchmark.wait(60)


def test_a_server_that_fails_says_why(tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text("properties: {}\nlayers: []\nmodels: [{name: a}]\n")

    with pytest.raises(FlatlandError, match=r'(?s)flatland_server has ended.*"model" is missing'):
        ServerProcess(world).__enter__()


# The tests of one server come last, so that it does not run during the others.


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """Two robots, twice as fast as real time.

    A topic's queue holds 10 messages: a subscriber that gets no core for 25 ms loses none.
    """
    world = write_world(tmp_path_factory.mktemp("world"), WORLDS, 2)
    with ServerProcess(world, update_rate=400) as server:
        yield server


@pytest.fixture
def subscribe(server):
    """Starts a subscriber with these arguments; it ends with the test."""
    subscribers = []

    def start(*arguments):
        subscribers.append(server.subscribe(f"subscriber{len(subscribers)}", *arguments))
        return subscribers[-1]

    yield start
    for subscriber in subscribers:
        if not subscriber.process.has_ended:
            server.end(subscriber.process)


def test_a_subscriber_receives_all_that_is_sent(subscribe):
    subscriber = subscribe("--robots")
    subscriber.wait_until_connected()
    begin = subscriber.next_reading(after=subscriber.next_reading().real + 0.5)
    end = subscriber.next_reading(after=begin.real + 2.0)

    seconds = end.simulated - begin.simulated
    received = {name: end.messages[name] - begin.messages[name] for name in end.messages}
    # The state may arrive before or after a few messages of the same time.
    assert seconds > 1.0
    assert received[LASER] == pytest.approx(2 * 10 * seconds, abs=8)
    assert received[ODOMETRY] == pytest.approx(2 * 200 * seconds, abs=40)
    assert received[TF] == pytest.approx(200 * seconds, abs=20)


def test_a_subscriber_leaves_clock_alone(server, subscribe):
    subscribe("--robots").wait_until_connected()

    assert server.subscribers("/clock") == {"/rosout"}


def test_a_stopped_subscriber_does_not_block_the_simulation(server, subscribe):
    subscriber = subscribe("--robots")
    subscriber.wait_until_connected()
    before = server.measure(1.0)

    subscriber.process.stop()
    server.measure(2.0)  # fills its sockets
    memory = server.server.memory
    during = server.measure(3.0)
    grown = server.server.memory - memory
    subscriber.process.resume()

    assert during.times_real_time > 0.5 * before.times_real_time
    assert grown < 5.0  # MB: what is not read is dropped
    again = subscriber.next_reading()
    later = subscriber.next_reading(after=again.real + 1.0)
    assert later.messages[LASER] > again.messages[LASER]

"""The server while its surroundings fail: the master, connections, file descriptors."""

import resource
import signal
import time
from pathlib import Path

import pytest
import tcpros_client
from rosgraph_msgs.msg import Clock
from running_server import USUAL_FILES, Master, Server, wait_until
from std_srvs.srv import Empty

pytestmark = pytest.mark.slow


@pytest.fixture
def master():
    master = Master()
    yield master
    master.kill()


@pytest.fixture
def start_server(master, tmp_path):
    servers = []

    def start(**options):
        servers.append(Server(master, tmp_path / f"server{len(servers)}.log", **options))
        return servers[-1]

    yield start
    for server in servers:
        server.kill()


def assert_time_goes_on(clock, seconds):
    """Simulated time goes on like real time, as seen on a connection to /clock."""
    first = tcpros_client.next_message(clock, Clock).clock.to_sec()
    begin = time.monotonic()
    while time.monotonic() < begin + seconds:
        last = tcpros_client.next_message(clock, Clock).clock.to_sec()
    assert last - first > 0.5 * seconds


def test_a_master_that_is_stopped_then_dies_does_not_stop_time(master, start_server):
    server = start_server()
    clock = tcpros_client.subscribe(server.uri, "/clock", Clock)
    topics = master.topics()

    master.process.send_signal(signal.SIGSTOP)
    spawning = [server.spawn("while_stopped")]
    assert_time_goes_on(clock, 0.5)
    master.kill()
    spawning.append(server.spawn("while_dead"))
    assert_time_goes_on(clock, 0.5)

    assert all(answer.success for answer in spawning)
    assert all("master" in answer.message for answer in spawning)
    assert "does not answer" in server.log

    # A new master knows nothing.
    master.start()
    wait_until(lambda: topics <= master.topics(), "the topics to be registered again")
    wait_until(lambda: "/while_dead/scan" in master.topics(), "those of the new robots")
    assert master.ask("lookupService", "/spawn_model")
    assert server.delete("while_dead").success
    wait_until(lambda: "/while_dead/scan" not in master.topics(), "those of the deleted one")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_server_while_the_master_is_stopped(master, start_server, number):
    server = start_server()
    master.process.send_signal(signal.SIGSTOP)

    begin = time.monotonic()
    server.process.send_signal(number)
    assert server.process.wait(10) == 0

    assert time.monotonic() - begin < 4.0
    assert "Traceback" not in server.log


def test_silent_connections_are_not_noticed(start_server):
    server = start_server()
    silent = [server.connect() for _ in range(100)]
    half = server.connect()
    half.sendall(b"\xff\x00\x00\x00half a header")

    begin = time.monotonic()
    server.call("/pause", Empty)
    clock = tcpros_client.subscribe(server.uri, "/clock", Clock)
    server.call("/resume", Empty)
    tcpros_client.next_message(clock, Clock)

    assert time.monotonic() - begin < 5.0  # without them: some milliseconds
    for connection in (*silent, half):
        connection.close()


def test_a_topic_takes_no_file_descriptor(start_server):
    server = start_server()
    server.spawn("first")
    before = server.open_files()
    names = [f"r{number}" for number in range(40)]
    for name in names:
        assert server.spawn(name).success

    assert server.open_files() <= before + 2
    for name in names:
        assert server.delete(name).success
    assert server.open_files() <= before + 2


def test_the_soft_limit_of_open_files_is_raised(start_server):
    server = start_server(max_files=256)

    limits = Path(f"/proc/{server.process.pid}/limits").read_text()
    [line] = [line for line in limits.splitlines() if line.startswith("Max open files")]
    assert int(line.split()[3]) > USUAL_FILES


def test_the_server_outlives_a_lack_of_file_descriptors(start_server):
    server = start_server()
    pid = server.process.pid
    used = server.open_files()
    hard = resource.prlimit(pid, resource.RLIMIT_NOFILE)[1]
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (used + 20, hard))
    connections = [server.connect() for _ in range(60)]
    wait_until(lambda: "have to wait" in server.log, "the error")
    for connection in connections:
        connection.close()

    server.call("/pause", Empty)
    server.call("/resume", Empty)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (server.open_files(), hard))
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (used + 100, hard))
    assert server.spawn("robot_after").success
    assert "Traceback" not in server.log

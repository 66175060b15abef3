"""The server while its surroundings fail: the master, connections, file descriptors."""

import contextlib
import os
import resource
import signal
import socket
import subprocess
import time
import xmlrpc.client
from pathlib import Path
from urllib.parse import urlparse

import pytest
import tcpros_client
from flatland_msgs.srv import DeleteModel, SpawnModel
from geometry_msgs.msg import Pose2D
from ros_processes import free_port
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Empty

WORLDS = Path(__file__).resolve().parents[1] / "worlds"
ROBOT = WORLDS / "office" / "turtlebot.model.yaml"
NODE = "/flatland_server"
LIMIT = 30.0  # s
USUAL_FILES = 1024  # the soft limit of open files

pytestmark = pytest.mark.slow


def wait_until(holds, what):
    deadline = time.monotonic() + LIMIT
    while True:
        value = holds()
        if value:
            return value
        assert time.monotonic() < deadline, f"waited for {what}"
        time.sleep(0.02)


class Master:
    """A ROS master on a port of its own, which can be started again there."""

    def __init__(self):
        self.port = free_port()
        self.uri = f"http://127.0.0.1:{self.port}"
        self.start()

    def start(self):
        self.process = subprocess.Popen(
            ["rosmaster", "--core", "-p", str(self.port)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        wait_until(lambda: self.ask("getPid"), "the master")

    def ask(self, method, *arguments):
        """The value of its answer, None if there is none."""
        try:
            proxy = xmlrpc.client.ServerProxy(self.uri)
            code, _, value = getattr(proxy, method)("/test", *arguments)
        except OSError:
            return None
        return value if code == 1 else None

    def topics(self):
        """The topics that the server publishes."""
        publishers = self.ask("getSystemState")[0]
        return {topic for topic, nodes in publishers if NODE in nodes}

    def kill(self):
        self.process.kill()
        self.process.wait()


class Server:
    """The server's node in the test room."""

    def __init__(self, master, log, max_files=USUAL_FILES):
        self._log = log
        self._master = master
        hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        with log.open("w") as file:
            self.process = subprocess.Popen(
                [
                    *("rosrun", "flatland_server", "flatland_server", f"__name:={NODE[1:]}"),
                    *(f"_world_path:={WORLDS / 'test_room' / 'world.yaml'}", "_show_viz:=true"),
                ],
                env={**os.environ, "ROS_MASTER_URI": master.uri},
                stdout=file,
                stderr=subprocess.STDOUT,
                preexec_fn=lambda: resource.setrlimit(
                    resource.RLIMIT_NOFILE, (max_files, min(hard, max(max_files, 65536)))
                ),
            )
        wait_until(lambda: "running" in self.log, "the server to run")
        self.uri = master.ask("lookupNode", NODE)
        self._services = {
            name: master.ask("lookupService", name)
            for name in ("/spawn_model", "/delete_model", "/pause", "/resume")
        }

    @property
    def log(self):
        return self._log.read_text()

    def call(self, service_name, service, **request):
        uri = self._services[service_name]
        return tcpros_client.call_service(uri, service_name, service, **request)

    def spawn(self, name):
        pose = Pose2D(0.0, 0.0, 0.0)
        return self.call(
            "/spawn_model", SpawnModel, yaml_path=str(ROBOT), name=name, ns=name, pose=pose
        )

    def delete(self, name):
        return self.call("/delete_model", DeleteModel, name=name)

    def open_files(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def connect(self):
        """A connection to its port for topics and services, on which nothing is sent."""
        place = urlparse(self._services["/pause"])
        return socket.create_connection((place.hostname, place.port), 5.0)


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
        server.process.kill()
        server.process.wait()


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

    # Connections for service calls are closed a little later.
    wait_until(lambda: server.open_files() <= before + 2, "no more open files")
    for name in names:
        assert server.delete(name).success
    wait_until(lambda: server.open_files() <= before + 2, "no more open files")


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


def request_shutdown(server):
    """What rosnode kill does."""
    with contextlib.suppress(OSError):  # the server may end before it answers
        xmlrpc.client.ServerProxy(server.uri).shutdown("/test", "a test")


@pytest.mark.parametrize(
    "end",
    [lambda server: server.process.send_signal(signal.SIGINT), request_shutdown],
    ids=["signal", "rosnode kill"],
)
def test_the_master_knows_nothing_of_a_server_that_has_ended(master, start_server, end):
    server = start_server()
    for number in range(60):
        assert server.spawn(f"r{number}").success

    end(server)
    assert server.process.wait(10) == 0

    state = master.ask("getSystemState")
    left = [name for part in state for name, nodes in part if NODE in nodes]
    assert left == []

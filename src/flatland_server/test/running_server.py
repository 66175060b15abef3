"""A ROS master and a server's node as processes, for tests that disturb them."""

import os
import resource
import signal
import socket
import subprocess
import time
import xmlrpc.client
from pathlib import Path
from typing import Any, Dict, Set, Tuple
from urllib.parse import urlparse

import tcpros_client
from flatland_msgs.srv import DeleteModel, SpawnModel
from geometry_msgs.msg import Pose2D
from ros_processes import executable, free_port
from rosgraph_msgs.msg import Clock
from waiting import wait_until

WORLDS = Path(__file__).resolve().parents[1] / "worlds"
ROBOT = WORLDS / "office" / "turtlebot.model.yaml"
NODE = "/flatland_server"
SERVICES = (
    *("/spawn_model", "/delete_model", "/move_model", "/get_model_markers"),
    *("/spawn_model_from_string", "/spawn_models", "/delete_models", "/step_world", "/seek"),
    *("/pause", "/resume", "/toggle_pause", "/change_rate", "/open_world", "/save_world"),
    *("/save_state", "/load_state", "/reset", "/reload_world", "/undo", "/redo"),
)
USUAL_FILES = 1024  # the soft limit of open files


class Master:
    """A ROS master on a port of its own, which can be started again there."""

    def __init__(self) -> None:
        self.port = free_port()
        self.uri = f"http://127.0.0.1:{self.port}"
        self.start()

    def start(self) -> None:
        self.process = subprocess.Popen(
            ["rosmaster", "--core", "-p", str(self.port)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        wait_until(lambda: self.ask("getPid"), "the master")

    def ask(self, method: str, *arguments: Any, caller: str = "/test") -> Any:
        """Calls a method of the master. Returns the value of its answer, None if there is none."""
        try:
            proxy = xmlrpc.client.ServerProxy(self.uri)
            code, _, value = getattr(proxy, method)(caller, *arguments)
        except OSError:
            return None
        return value if code == 1 else None

    def topics(self) -> Set[str]:
        """The topics that the server publishes."""
        return self._of_server(0)

    def subscribed_topics(self) -> Set[str]:
        """The topics that the server subscribes to."""
        return self._of_server(1)

    def _of_server(self, index: int) -> Set[str]:
        return {topic for topic, nodes in self.ask("getSystemState")[index] if NODE in nodes}

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


class Server:
    """The server's node in the test room.

    Args:
        master: its ROS master.
        log: the file of its output.
        max_files: its soft limit of open files.
        is_awaited: whether to wait until it runs.
    """

    def __init__(
        self, master: Master, log: Path, max_files: int = USUAL_FILES, is_awaited: bool = True
    ) -> None:
        self._log = log
        self._master = master
        self._services: Dict[str, str] = {}
        hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        with log.open("a") as file:
            self.process = subprocess.Popen(
                [
                    *(executable("flatland_server", "flatland_server"), f"__name:={NODE[1:]}"),
                    *(f"_world_path:={WORLDS / 'test_room' / 'world.yaml'}", "_show_viz:=true"),
                ],
                env={**os.environ, "ROS_MASTER_URI": master.uri},
                stdout=file,
                stderr=subprocess.STDOUT,
                preexec_fn=lambda: prepare(max_files, min(hard, max(max_files, 65536))),
            )
        if is_awaited:
            try:
                wait_until(lambda: "running" in self.log, "the server to run")
            except AssertionError:
                self.kill()
                raise
            self.look_up()
            self.topics = master.topics()
            """The topics that it publishes from the start."""
            self.subscribed_topics = master.subscribed_topics()

    @property
    def log(self) -> str:
        return self._log.read_text(errors="replace")

    @property
    def is_running(self) -> bool:
        return self.process.poll() is None

    def empty_log(self) -> None:
        """Forgets the log so far."""
        os.truncate(self._log, 0)

    def look_up(self) -> bool:
        """Asks the master where the node and its services are. Returns whether it knows all."""
        self.uri = self._master.ask("lookupNode", NODE)
        self._services = {name: self._master.ask("lookupService", name) for name in SERVICES}
        return all(self._services.values())

    def service_address(self) -> Tuple[str, int]:
        """Its host and port for topics and services."""
        place = urlparse(self._services["/pause"])
        assert place.hostname is not None
        assert place.port is not None
        return place.hostname, place.port

    def call(self, service_name: str, service: Any, **request: Any) -> Any:
        uri = self._services[service_name]
        return tcpros_client.call_service(uri, service_name, service, **request)

    def spawn(self, name: str) -> Any:
        pose = Pose2D(0.0, 0.0, 0.0)
        return self.call(
            "/spawn_model", SpawnModel, yaml_path=str(ROBOT), name=name, ns=name, pose=pose
        )

    def delete(self, name: str) -> Any:
        return self.call("/delete_model", DeleteModel, name=name)

    def open_files(self) -> int:
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def connect(self) -> socket.socket:
        """A connection to its port for topics and services, on which nothing is sent."""
        return socket.create_connection(self.service_address(), 5.0)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


def simulated_time(clock: socket.socket, seconds: float) -> float:
    """The simulated time that passes in a real time [s], on a connection to /clock.

    Raises:
        OSError: there is no message.
    """
    first = last = tcpros_client.next_message(clock, Clock).clock
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        last = tcpros_client.next_message(clock, Clock).clock
    return float((last - first).to_sec())


def prepare(max_files: int, hard: int) -> None:
    """Sets signals and the limit of open files of a new process as a terminal does."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a background shell ignores it
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # and nohup this one
    resource.setrlimit(resource.RLIMIT_NOFILE, (max_files, hard))

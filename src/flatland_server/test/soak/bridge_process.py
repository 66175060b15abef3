"""A bridge as a process, `flatland serve` or the node `bridge`, and raw clients of it."""

import os
import re
import select
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, List, Mapping, Optional, Union
from urllib.parse import urlsplit

from ros2_environment import DISTRIBUTIONS, Ros2Environment
from ros_processes import executable
from running_server import WORLDS, Master, Server
from soak.usage import Usage
from waiting import wait_until
from websockets.client import ClientProtocol
from websockets.frames import Frame, Opcode
from websockets.protocol import State
from websockets.uri import parse_uri

WORLD = WORLDS / "test_room" / "world.yaml"
FOXGLOVE_PROTOCOL = "foxglove.sdk.v1"
SERVE = ("-m", "flatland2d", "serve", str(WORLD), "--port", "0", "--foxglove-port", "0")
LIMIT = 5.0
"""Within this time a client is answered [s]; on an idle machine: some milliseconds."""

Data = Union[str, bytes]


class Closed(ConnectionError):
    """The server has closed a connection.

    Attributes:
        code: of the WebSocket protocol; None without a closing handshake.
    """

    def __init__(self, code: Optional[int], reason: str) -> None:
        super().__init__(f"closed with the code {code} {reason}")
        self.code = code


class Peer:
    """A WebSocket client that can do what a library would not: stop reading, or send half a frame.

    Args:
        url: the server's url.
        buffer: size of the receive buffer [bytes], for a client that is to stall soon.
    """

    def __init__(self, url: str, buffer: int = 0) -> None:
        place = urlsplit(url)
        self.socket = socket.socket()
        if buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.socket.settimeout(LIMIT)
        assert place.hostname is not None
        self.socket.connect((place.hostname, place.port))
        self._protocol: Any = ClientProtocol(
            parse_uri(url), subprotocols=[FOXGLOVE_PROTOCOL], max_size=None
        )
        self._frames: List[Frame] = []
        self._protocol.send_request(self._protocol.connect())
        self._flush()
        while self._protocol.state is State.CONNECTING:
            self._read(LIMIT)
        self._frames = self._protocol.events_received()[1:]

    def send(self, data: Data) -> None:
        """Sends a message.

        Raises:
            OSError: the server does not read, or has closed the connection.
        """
        if self._protocol.state is not State.OPEN:
            raise self._closed()
        if isinstance(data, str):
            self._protocol.send_text(data.encode(errors="surrogatepass"))
        else:
            self._protocol.send_binary(data)
        self._flush()

    def receive(self, timeout: float = LIMIT) -> Data:
        """The next message.

        Raises:
            Closed: the connection is closed.
            TimeoutError: there is none within a time [s].
        """
        end = time.monotonic() + timeout
        while True:
            while self._frames:
                frame = self._frames.pop(0)
                if frame.opcode in (Opcode.TEXT, Opcode.BINARY):
                    is_text = frame.opcode is Opcode.TEXT
                    return str(frame.data, "utf-8") if is_text else bytes(frame.data)
            if self._protocol.state is not State.OPEN:
                raise self._closed()
            self._read(max(0.0, end - time.monotonic()))
            self._frames += self._protocol.events_received()

    def close(self) -> None:
        self.socket.close()

    def __enter__(self) -> "Peer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _closed(self) -> Closed:
        received = self._protocol.close_rcvd
        return Closed(received.code, received.reason) if received else Closed(None, "")

    def _flush(self) -> None:
        for data in self._protocol.data_to_send():
            if data:
                self.socket.sendall(data)

    def _read(self, timeout: float) -> None:
        if not select.select([self.socket], [], [], timeout)[0]:
            raise TimeoutError("the server has sent nothing")
        try:
            data = self.socket.recv(1 << 20)
        except OSError:
            data = b""
        if data:
            self._protocol.receive_data(data)
        else:
            self._protocol.receive_eof()
        with suppress(OSError):
            self._flush()  # answers to pings


class Bridge:
    """A bridge that runs.

    Args:
        command: command line of the process.
        log: the file of its output.
        planted: a folder with modules that no client may import.
        server: the ROS server beside it, if any.
        environment: variables of the process.

    Attributes:
        python: the process's Python, if it is one.
        environment: variables of the process.
        rosbridge: its address.
        foxglove: its address.
    """

    def __init__(
        self,
        command: List[str],
        log: Path,
        planted: Path,
        server: Optional[Server] = None,
        environment: Mapping[str, str] = os.environ,
    ) -> None:
        self._log = log
        self._server = server
        self.python, self.environment = command[0], environment
        paths = [str(planted), environment.get("PYTHONPATH", "")]
        with log.open("w") as file:
            self.process = subprocess.Popen(
                command,
                env={**environment, "PYTHONPATH": os.pathsep.join(paths), "PYTHONUNBUFFERED": "1"},
                stdout=file,
                stderr=subprocess.STDOUT,
            )
        try:
            wait_until(lambda: "Foxglove: " in self.log, "the bridge to run")
        except AssertionError:
            self.kill()
            raise
        port = re.search(r"page: http://[^:]+:(\d+)", self.log)
        foxglove_port = re.search(r"Foxglove: ws://[^:]+:(\d+)", self.log)
        assert port is not None
        assert foxglove_port is not None
        self.rosbridge = f"ws://127.0.0.1:{port[1]}/"
        self.foxglove = f"ws://127.0.0.1:{foxglove_port[1]}/"

    @property
    def log(self) -> str:
        """The output of the bridge, and of the ROS server beside it."""
        return self._log.read_text(errors="replace") + (self._server.log if self._server else "")

    def empty_log(self) -> None:
        """Forgets the log so far."""
        os.truncate(self._log, 0)
        if self._server:
            self._server.empty_log()

    @property
    def is_running(self) -> bool:
        return self.process.poll() is None

    def usage(self) -> Usage:
        return Usage.of(self.process.pid)

    def forget_peak(self) -> None:
        """Begins to measure the largest memory anew."""
        Path(f"/proc/{self.process.pid}/clear_refs").write_text("5")

    def peak(self) -> float:
        """The largest resident memory since `forget_peak` [MB]."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.partition("VmHWM:")[2].split()[0]) / 1024

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


def serve(processes: ExitStack, folder: Path, planted: Path) -> Bridge:
    """Starts `flatland serve`."""
    command = [sys.executable, *SERVE]
    bridge = Bridge(command, folder / "serve.log", planted)
    processes.callback(bridge.kill)
    return bridge


def serve_ros2(processes: ExitStack, folder: Path, planted: Path) -> Bridge:
    """Starts `flatland serve --ros2` in an environment with ROS 2."""
    ros2 = Ros2Environment(DISTRIBUTIONS[0])
    domain = {"ROS_DOMAIN_ID": str(101 + os.getpid() % 100), "ROS_LOG_DIR": str(folder)}
    command = [str(ros2.python), *SERVE, "--ros2"]
    bridge = Bridge(
        command, folder / "ros2.log", planted, environment={**ros2.environment(), **domain}
    )
    processes.callback(bridge.kill)
    return bridge


def start_node(processes: ExitStack, folder: Path, planted: Path) -> Bridge:
    """Starts a ROS master, the server and the node `bridge`."""
    master = Master()
    processes.callback(master.kill)
    master.ask("setParam", "/use_sim_time", True)  # as server.launch does
    server = Server(master, folder / "server.log")
    processes.callback(server.kill)
    command = [executable("flatland_bridge", "bridge"), "_port:=0", "_foxglove_port:=0"]
    command.append(f"__master:={master.uri}")
    bridge = Bridge(command, folder / "bridge.log", planted, server)
    processes.callback(bridge.kill)
    return bridge

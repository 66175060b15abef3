"""flatland_server as a user runs it: with a ROS master, rosout, the node, and subscribers."""

import os
import shutil
import sys
import tempfile
import time
import xmlrpc.client
from pathlib import Path
from types import TracebackType
from typing import Any, Dict, List, NamedTuple, Optional, Set, Type

from flatland_benchmark.process import Process, wait_until
from flatland_server.testing.ports import free_port

_NAME = "/flatland_benchmark"  # our name in calls to the master


def executable(package: str, node: str) -> str:
    """The file of a package's node; rosrun starts several processes to find it."""
    from roslib.packages import find_node  # other cases run without ROS

    file: str = find_node(package, node)[0]
    return file


class Reading(NamedTuple):
    """The counts of a subscriber when it received the simulation's state."""

    real: float
    """Real time, as of time.monotonic() [s]."""

    simulated: float
    """Simulated time [s]."""

    is_connected: bool
    """True if all its topics have a publisher."""

    messages: Dict[str, int]
    """Number of messages received, by message type."""

    missing: int
    """Number of messages with headers that were lost between those that were received."""


class CountingSubscriber:
    """A flatland_counting_subscriber and its readings."""

    def __init__(self, process: Process, server: "ServerProcess") -> None:
        self.process = process
        self._server = server
        self._readings: List[Reading] = []

    def next_reading(self, after: float = 0.0) -> Reading:
        """The first new reading at or after the real time `after`."""
        self._collect()
        self._readings.clear()
        while True:
            reading: Reading = self._server.wait_until(self._pop, "the simulation's state")
            if reading.real >= after:
                return reading

    def wait_until_connected(self) -> None:
        """Waits until all its topics are connected."""
        self._server.wait_until(
            lambda: self.next_reading().is_connected,
            f"{self.process.name} to be connected",
            limit=120.0,
        )

    def _collect(self) -> None:
        for line in self.process.new_lines():
            if "simulated" in line:
                is_connected = line["connected"] == line["topics"]
                self._readings.append(
                    Reading(
                        line["real"],
                        line["simulated"],
                        is_connected,
                        line["received"],
                        line["missing"],
                    )
                )

    def _pop(self) -> Optional[Reading]:
        if not self._readings:
            self._collect()
        return self._readings.pop(0) if self._readings else None


class Interval(NamedTuple):
    """The server's speed over some seconds of real time."""

    times_real_time: float
    cpu_per_step: float
    """Processor time of all threads per step [us]."""


class ServerProcess:
    """A running server, as a context manager: leaving it ends all processes.

    Args:
        world_file: path of the world file to run.
        update_rate: steps per second of real time.
    """

    STEP_SIZE = 0.005

    def __init__(self, world_file: Path, update_rate: float = float("inf")) -> None:
        self._world_file = world_file
        self._update_rate = update_rate
        self._folder = tempfile.TemporaryDirectory(prefix="flatland_benchmark_")
        self._processes: List[Process] = []
        self._port = free_port()
        self.uri = f"http://127.0.0.1:{self._port}"
        """The address of the ROS master."""
        self._master = xmlrpc.client.ServerProxy(self.uri)
        self._environment = {
            **{k: v for k, v in os.environ.items() if k not in ("ROS_HOSTNAME", "ROS_NAMESPACE")},
            "ROS_MASTER_URI": self.uri,
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": self._folder.name,
            "ROS_LOG_DIR": self._folder.name,
            "XDG_CONFIG_HOME": self._folder.name,
        }

    def __enter__(self) -> "ServerProcess":
        try:
            self._start()
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        traceback: Optional[TracebackType],
    ) -> None:
        self._end()

    def _start(self) -> None:
        rosmaster = [sys.executable, shutil.which("rosmaster") or "rosmaster"]
        self.start("rosmaster", [*rosmaster, "--core", "-p", str(self._port)])
        self.wait_until(self._has_master, "the ROS master")
        self._master.setParam(_NAME, "/use_sim_time", True)
        self.start("rosout", [executable("rosout", "rosout")])
        self.wait_until(lambda: "/rosout" in self.subscribers("/clock"), "rosout")
        self.started_at = time.time()
        node = [executable("flatland_server", "flatland_server"), "__name:=flatland_server"]
        self.server = self.start(
            "flatland_server",
            [
                *node,
                f"_world_path:={self._world_file}",
                f"_update_rate:={self._update_rate}",
                f"_step_size:={self.STEP_SIZE}",
            ],
        )
        self.observer = self.subscribe("observer")
        self.observer.next_reading()

    def start(self, name: str, command: List[str]) -> Process:
        """Starts a program with our master; leaving the context ends it."""
        process = Process(name, command, Path(self._folder.name), self._environment)
        self._processes.append(process)
        return process

    def subscribe(self, name: str, *arguments: str) -> CountingSubscriber:
        """Starts a flatland_counting_subscriber with these arguments."""
        program = executable("flatland_benchmark", "flatland_counting_subscriber")
        return CountingSubscriber(self.start(name, [program, *arguments]), self)

    def call(self, name: str, command: List[str], limit: float = 60.0) -> str:
        """Runs a program to completion and returns its output.

        Raises:
            FlatlandError: it takes longer than `limit` seconds, or fails.
        """
        process = self.start(name, command)
        process.wait(limit)
        self.end(process)
        return process.output

    def end(self, process: Process) -> None:
        """Ends one program."""
        process.end()
        self._processes.remove(process)

    def wait_until(self, holds: Any, what: str, limit: float = 60.0) -> Any:
        """The first true value of `holds()`.

        Raises:
            FlatlandError: it takes too long, or a process has ended; the text has their output.
        """
        return wait_until(holds, what, self._processes, limit)

    def subscribers(self, topic: str) -> Set[str]:
        """The nodes that have subscribed to a topic."""
        answer: Any = self._master.getSystemState(_NAME)
        _, _, (_, subscribers, _) = answer
        return {node for name, nodes in subscribers if name == topic for node in nodes}

    def measure(self, seconds: float) -> Interval:
        """Measures the server's speed over some seconds of real time."""
        begin, cpu = self.observer.next_reading(), self.server.cpu_seconds
        started = time.monotonic()
        end = self.observer.next_reading(begin.real + seconds)
        cores = (self.server.cpu_seconds - cpu) / (time.monotonic() - started)
        times_real_time = (end.simulated - begin.simulated) / (end.real - begin.real)
        return Interval(times_real_time, cores / times_real_time * self.STEP_SIZE * 1e6)

    def settle(self, seconds: float) -> None:
        """Waits some seconds of real time."""
        self.observer.next_reading(time.monotonic() + seconds)

    def _has_master(self) -> bool:
        try:
            self._master.getPid(_NAME)
        except OSError:
            return False
        return True

    def _end(self) -> None:
        while self._processes:
            self._processes.pop().end()
        self._folder.cleanup()

"""Cases that run the real server under a ROS master of its own, with and without subscribers."""

import math
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator, Optional

from flatland_benchmark.case import Figures, case
from flatland_benchmark.highest_rate import MEASURING, highest_rate
from flatland_benchmark.robot_worlds import write_world
from flatland_benchmark.server_process import Interval, ServerProcess

_ROBOTS = (1, 10, 100)
_MEASURING = 5.0
"""Duration of a measurement [s of real time]."""
_SETTLING = 1.0
"""Waiting time before a measurement [s]."""
_REAL_TIME = 200.0
"""Steps per second of real time, where the loop is not unbounded."""

_SENT = {
    "sensor_msgs/LaserScan": ("scans received [%]", 10.0, 0.0),
    "nav_msgs/Odometry": ("odometry received [%]", 1.0 / ServerProcess.STEP_SIZE, 0.0),
    "tf2_msgs/TFMessage": ("tf received [%]", 0.0, 1.0 / ServerProcess.STEP_SIZE),
}
"""By type: a figure's name, and the messages sent per simulated second by each robot and by all
together."""


@contextmanager
def _robots(worlds: Path, robots: int, update_rate: float) -> Iterator[ServerProcess]:
    """A server with this many robots."""
    with tempfile.TemporaryDirectory(prefix="flatland_benchmark_") as folder:
        world = write_world(Path(folder), worlds, robots)
        with ServerProcess(world, update_rate) as server:
            server.settle(_SETTLING)
            yield server


def _figures(interval: Interval, server: ServerProcess) -> Figures:
    return {
        "times real time": interval.times_real_time,
        "CPU per step [us]": interval.cpu_per_step,
        "memory [MB]": server.server.memory,
    }


@case("serve_{robots}", "the server as fast as it goes, robots: {robots}", robots=_ROBOTS)
def serve(worlds: Path, robots: int) -> Figures:
    """The server without subscribers, except rosout to /clock."""
    with _robots(worlds, robots, math.inf) as server:
        return _figures(server.measure(_MEASURING), server)


@case("serve_{robots}_heard", "the same with a subscriber to all topics", robots=_ROBOTS)
def serve_with_subscriber(worlds: Path, robots: int) -> Figures:
    """One subscriber to all robots' topics; reports the share of the messages that it receives.

    It connects in real time: a node that messages flood on its first connections is too slow to
    open the others.
    """
    with _robots(worlds, robots, _REAL_TIME) as server:
        subscriber = server.subscribe("subscriber", "--robots")
        subscriber.wait_until_connected()
        _change_rate(server, math.inf)
        server.settle(_SETTLING)
        before = subscriber.next_reading()
        interval = server.measure(_MEASURING)
        after = subscriber.next_reading()
        figures = _figures(interval, server)
    seconds = after.simulated - before.simulated
    for name, (figure, each, together) in _SENT.items():
        received = after.messages[name] - before.messages[name]
        figures[figure] = 100.0 * received / ((each * robots + together) * seconds)
    return figures


@case("serve_{robots}_all", "the highest rate with all messages received", robots=_ROBOTS)
def serve_all(worlds: Path, robots: int) -> Figures:
    """One subscriber to all robots' topics, at the highest rate at which it misses none."""
    with _robots(worlds, robots, _REAL_TIME) as server:
        subscriber = server.subscribe("subscriber", "--robots")
        subscriber.wait_until_connected()

        def reached(rate: float) -> Optional[float]:
            _change_rate(server, rate)
            server.settle(_SETTLING)
            before = subscriber.next_reading().missing
            interval = server.measure(MEASURING)
            has_all = subscriber.next_reading().missing == before
            return interval.times_real_time if has_all else None

        return {"times real time": highest_rate(reached)}


def _change_rate(server: ServerProcess, rate: float) -> None:
    value = ".inf" if math.isinf(rate) else repr(rate)
    server.call("change_rate", ["rosservice", "call", "/change_rate", f"{{rate: {value}}}"])

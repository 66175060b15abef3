"""Cases that run the real server under a ROS master of its own: speed, subscribers."""

import json
import math
import shutil
import sys
import tempfile
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from statistics import median
from typing import Iterator, List, Tuple

from flatland_benchmark.case import Case, Figures
from flatland_benchmark.figures import ROBOTS, durations, in_words
from flatland_benchmark.robot_worlds import write_world
from flatland_benchmark.server_process import CountingSubscriber, Interval, ServerProcess

ROBOTS_ALONE = (1, 10, 100)
ROBOTS_SUBSCRIBED_TO = (1, 10, 100)

STEPS_PER_CALL = (1, 10)

MEASURING = 5.0
"""Duration of a measurement in most cases [s of real time]."""

SETTLING = 1.0
"""Waiting time before a measurement [s]."""

STALLED = 4.0
"""Duration for which a subscriber reads nothing [s]."""

GROWING = 10.0
"""Time between two readings of memory [s]."""

SPAWNED = 200
"""Number of models that are spawned."""

SLOW_EXPRESSION = "local r = 0.2 for i = 1, 8e6 do r = r + i % 3 - i % 3 end return r"

SLOW_MODEL = "bodies:\n- name: base\n  footprints:\n" + 8 * (
    f"  - {{type: circle, density: 1, radius: '$eval {SLOW_EXPRESSION}'}}\n"
)
"""A model file with expressions that take about half a second."""

REAL_TIME = 200.0
"""Steps per second of real time, where the loop is not unbounded."""

_SENT = {
    "sensor_msgs/LaserScan": ("scans received [%]", 10.0, 0.0),
    "nav_msgs/Odometry": ("odometry received [%]", 1.0 / ServerProcess.STEP_SIZE, 0.0),
    "tf2_msgs/TFMessage": ("tf received [%]", 0.0, 1.0 / ServerProcess.STEP_SIZE),
}
"""By type: a figure's name, and the messages sent per simulated second by each robot and by all
together."""


@contextmanager
def _robots(
    worlds: Path, robots: int, rosout: bool = True, update_rate: float = math.inf
) -> Iterator[ServerProcess]:
    """A server with this many robots, by default as fast as it goes."""
    with tempfile.TemporaryDirectory(prefix="flatland_benchmark_") as folder:
        world = write_world(Path(folder), worlds, robots)
        with ServerProcess(world, update_rate, rosout=rosout) as server:
            server.settle(SETTLING)
            yield server


@contextmanager
def _robots_subscribed_to(
    worlds: Path, robots: int
) -> Iterator[Tuple[ServerProcess, CountingSubscriber]]:
    """The same with a subscriber to all topics.

    It connects in real time: a node that messages flood on its first connections is too slow to
    open the others.
    """
    with _robots(worlds, robots, update_rate=REAL_TIME) as server:
        subscriber = _connected(server)
        server.call("change_rate", ["rosservice", "call", "/change_rate", "{rate: .inf}"])
        server.settle(SETTLING)
        yield server, subscriber


def _figures(interval: Interval, server: ServerProcess) -> Figures:
    return {
        "times real time": interval.times_real_time,
        "CPU per step [us]": interval.cpu_per_step,
        "memory [MB]": server.server.memory,
    }


def serve(worlds: Path, robots: int, rosout: bool = True) -> Figures:
    """The server without subscribers, except rosout to /clock."""
    with _robots(worlds, robots, rosout) as server:
        return _figures(server.measure(MEASURING), server)


def serve_with_subscriber(worlds: Path, robots: int) -> Figures:
    """One subscriber to all robots' topics; reports the share of the messages that it receives."""
    with _robots_subscribed_to(worlds, robots) as (server, subscriber):
        return _subscriber_figures(server, subscriber, robots)


class _MessageSender(ServerProcess):
    """In the server's place, a program that only sends; see `flatland_benchmark.message_sender`."""

    def __init__(self, robots: int, steps: int) -> None:
        super().__init__(Path())
        self._numbers = [str(robots), str(steps)]

    def _command(self) -> List[str]:
        return [sys.executable, "-m", "flatland_benchmark.message_sender", *self._numbers]


def send_with_subscriber(_: Path, robots: int, steps: int) -> Figures:
    """The same with a program that only sends."""
    with _MessageSender(robots, steps) as sender:
        subscriber = _connected(sender)
        sender.settle(SETTLING)
        return _subscriber_figures(sender, subscriber, robots)


def _subscriber_figures(
    server: ServerProcess, subscriber: CountingSubscriber, robots: int
) -> Figures:
    before = subscriber.next_reading()
    interval = server.measure(MEASURING)
    after = subscriber.next_reading()
    figures = _figures(interval, server)
    seconds = after.simulated - before.simulated
    for name, (figure, each, together) in _SENT.items():
        received = after.messages[name] - before.messages[name]
        figures[figure] = 100.0 * received / ((each * robots + together) * seconds)
    return figures


def _connected(server: ServerProcess) -> CountingSubscriber:
    subscriber = server.subscribe("subscriber", "--robots")
    subscriber.wait_until_connected()
    return subscriber


def stalled_subscriber(worlds: Path) -> Figures:
    """A subscriber in a stopped process: its messages are dropped."""
    with _robots_subscribed_to(worlds, 10) as (server, subscriber):
        before = server.measure(STALLED)
        subscriber.process.stop()
        server.settle(SETTLING)
        during = server.measure(STALLED)
    return {
        "times real time": before.times_real_time,
        "while stalled": during.times_real_time,
        "ratio": during.times_real_time / before.times_real_time,
    }


def grow(worlds: Path) -> Figures:
    """Growth of memory over time, with a hundred robots and a subscriber."""
    with _robots_subscribed_to(worlds, 100) as (server, _):
        begin, early = server.observer.next_reading(), server.server.memory
        server.settle(GROWING)
        end, late = server.observer.next_reading(), server.server.memory
    return {
        "memory [MB]": late,
        "growth [MB]": late - early,
        "simulated [s]": end.simulated - begin.simulated,
    }


def serve_real_time(worlds: Path) -> Figures:
    """The office at 200 Hz, with the intervals of /clock as a subscriber receives it."""
    with ServerProcess(worlds / "office" / "world.yaml", REAL_TIME) as server:
        server.settle(SETTLING)
        return _real_time_figures(server)


def serve_rviz(worlds: Path) -> Figures:
    """The office at 200 Hz with the window under Xvfb, drawn without a graphics card."""
    with ServerProcess(worlds / "office" / "world.yaml", REAL_TIME) as server:
        window = server.start(
            "flatland_viz",
            ["rosrun", "flatland_viz", "flatland_viz"],
            DISPLAY=server.start_screen(),
            LIBGL_ALWAYS_SOFTWARE="1",
        )
        server.wait_until(lambda: server.subscribers("/scan"), "the window")
        server.settle(3 * SETTLING)
        cpu, begin = window.cpu_seconds, time.monotonic()
        figures = _real_time_figures(server)
        cores = (window.cpu_seconds - cpu) / (time.monotonic() - begin)
    return {**figures, "window [% of a core]": 100.0 * cores}


def _real_time_figures(server: ServerProcess) -> Figures:
    subscriber = server.subscribe("subscriber", "--clock")
    subscriber.next_reading()
    interval = server.measure(MEASURING)
    clock = subscriber.end()
    diagnosis = server.diagnosis()
    return {
        "times real time": interval.times_real_time,
        "server [% of a core]": 100.0 * interval.cores,
        "step p50 [ms]": float(diagnosis["step period, median [ms]"]),
        "step p99 [ms]": float(diagnosis["step period, 99th percentile [ms]"]),
        "/clock p50 [ms]": clock["p50"] * 1e3,
        "/clock p99 [ms]": clock["p99"] * 1e3,
        "/clock worst [ms]": clock["worst"] * 1e3,
        "memory [MB]": server.server.memory,
    }


def spawn(worlds: Path) -> Figures:
    """Duration of a call of /spawn_model for the office's robot, in the office at 200 Hz."""
    model = worlds / "office" / "turtlebot.model.yaml"
    with ServerProcess(worlds / "office" / "world.yaml", REAL_TIME) as server:
        server.settle(SETTLING)
        client = ["rosrun", "flatland_benchmark", "flatland_spawner", str(model), str(SPAWNED)]
        seconds: List[float] = json.loads(server.call("spawner", client))["spawned"]
    return durations(seconds)


def slow_spawn(worlds: Path) -> Figures:
    """The intervals between ticks of /clock while a file that is slow to read is spawned."""
    with tempfile.TemporaryDirectory(prefix="flatland_benchmark_") as folder:
        model = Path(folder) / "slow.model.yaml"
        model.write_text(SLOW_MODEL)
        with ServerProcess(worlds / "office" / "world.yaml", REAL_TIME) as server:
            server.settle(SETTLING)
            subscriber = server.subscribe("subscriber", "--clock")
            subscriber.next_reading()
            client = ["rosrun", "flatland_benchmark", "flatland_spawner", str(model), "5"]
            seconds: List[float] = json.loads(server.call("spawner", client))["spawned"]
            clock = subscriber.end()
    return {
        "spawn p50 [ms]": median(seconds) * 1e3,
        "/clock p99 [ms]": clock["p99"] * 1e3,
        "/clock worst [ms]": clock["worst"] * 1e3,
    }


def train(worlds: Path) -> Figures:
    """Training episodes of 1,000 steps in the test room; see `training_episodes`."""
    episodes, steps = 3, 1000
    program = [sys.executable, "-m", "flatland_benchmark.training_episodes"]
    with ServerProcess(worlds / "test_room" / "world.yaml", REAL_TIME) as server:
        output = server.call("trainer", [*program, str(episodes), str(steps)], limit=300.0)
    seconds = json.loads(output)
    prepared = median(seconds["prepared"])
    return {
        "episode [s]": prepared + sum(seconds["stepped"]) / episodes,
        "reset, spawns and deletions [ms]": prepared * 1e3,
        **durations(seconds["stepped"]),
    }


SERVER_CASES: Tuple[Case, ...] = (
    *(
        Case(
            f"serve_{n}",
            f"the server as fast as it goes, {in_words(n)}, no subscriber but rosout to /clock",
            partial(serve, robots=n),
        )
        for n in ROBOTS
    ),
    *(
        Case(
            f"serve_{n}_alone",
            f"the same with {in_words(n)} and no subscriber at all",
            partial(serve, robots=n, rosout=False),
        )
        for n in ROBOTS_ALONE
    ),
    *(
        Case(
            f"serve_{n}_heard",
            f"the same with {in_words(n)} and a subscriber to all scans, odometry and transforms",
            partial(serve_with_subscriber, robots=n),
        )
        for n in ROBOTS_SUBSCRIBED_TO
    ),
    *(
        Case(
            f"limit_{n}_{steps}",
            f"a program that only sends the messages of {in_words(n)} to the same subscriber, "
            f"steps in one call: {steps}",
            partial(send_with_subscriber, robots=n, steps=steps),
        )
        for n in ROBOTS_SUBSCRIBED_TO
        for steps in STEPS_PER_CALL
    ),
    Case("serve_stalled", "10 robots, and a subscriber that stops reading", stalled_subscriber),
    Case("serve_grow", "memory of 100 robots with a subscriber, over time", grow),
    Case("serve_real_time", "the office with one robot at 200 Hz of real time", serve_real_time),
    *(
        [Case("serve_rviz", "the same with the window, drawn by software", serve_rviz)]
        if shutil.which("Xvfb") and shutil.which("rviz")
        else []
    ),
    Case("serve_spawn", "spawning a robot by /spawn_model", spawn),
    Case("serve_slow_spawn", "spawning a model from a file that takes long to read", slow_spawn),
    Case("serve_training", "training episodes: 20 spawns, 1,000 steps of 0.1 s with a scan", train),
)

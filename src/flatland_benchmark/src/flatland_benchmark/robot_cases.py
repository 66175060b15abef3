"""Cases with robots in this process, without a ROS master."""

import json
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

from flatland_benchmark.case import Case, Figures
from flatland_benchmark.figures import ROBOTS, durations, in_words, peak_memory
from flatland_benchmark.robot_worlds import write_world
from flatland_server.geometry import Pose
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport

_STEP_SIZE = 0.005
_SCAN_PERIOD = 20
"""Steps between two scans; a multiple of this is measured."""
_MEASURED = 2.0
"""Least duration of a measurement [s of real time]."""
_SPAWNS = 200


def run_robots(worlds: Path, robots: int) -> Figures:
    """This many robots in the office, as fast as it goes, without subscribers."""
    with tempfile.TemporaryDirectory() as folder:
        world = World.from_file(
            write_world(Path(folder), worlds, robots), LocalTransport(subscribed_topics=())
        )
    figures = run(world)
    figures["step per robot [us]"] = figures["step [us]"] / robots
    return {**figures, **peak_memory()}


def run_office(worlds: Path) -> Figures:
    """The office with its robot, with a subscriber to every topic in this process."""
    return {**run(World.from_file(worlds / "office/world.yaml")), **peak_memory()}


def run(world: World) -> Figures:
    """Steps a world for a while and returns the time per step."""
    stepped = Run(world, Timekeeper(_STEP_SIZE))

    def steps(count: int) -> None:
        for _ in range(count):
            stepped.step()

    steps(_SCAN_PERIOD)  # includes one-time work
    count = 0
    begin, cpu = time.perf_counter(), time.process_time()
    while time.perf_counter() < begin + _MEASURED:
        steps(_SCAN_PERIOD)
        count += _SCAN_PERIOD
    seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
    return {
        "times real time": count * _STEP_SIZE / seconds,
        "step [us]": seconds / count * 1e6,
        "CPU per step [us]": cpu / count * 1e6,
    }


def spawn(worlds: Path) -> Figures:
    """Spawns and deletes the office's robot again and again."""
    world = World.from_file(worlds / "office/world.yaml")
    times = []
    for i in range(_SPAWNS):
        begin = time.perf_counter()
        world.spawn_model(worlds / "office/turtlebot.model.yaml", f"robot{i}", f"robot{i}", Pose())
        times.append(time.perf_counter() - begin)
        world.delete_model(f"robot{i}")
    return durations(times)


def time_parts(worlds: Path, robots: int, subscribed: bool) -> Figures:
    """Time of a step by part. It imports rospy, so it is a program of its own."""
    with tempfile.TemporaryDirectory() as folder:
        world = write_world(Path(folder), worlds, robots)
        command = [sys.executable, "-m", "flatland_benchmark.step_parts", str(world)]
        if subscribed:
            command.append("--subscribed")
        output = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
    return {f"{part} [us]": value for part, value in json.loads(output).items()}


ROBOT_CASES = (
    *(
        Case(
            f"robots_{robots}",
            f"{in_words(robots)} in the office, in process, no subscribers",
            partial(run_robots, robots=robots),
        )
        for robots in ROBOTS
    ),
    *(
        Case(
            f"parts_{robots}" + ("_heard" if subscribed else ""),
            f"parts of a step, {in_words(robots)}, "
            f"{'all topics' if subscribed else 'no topics'} subscribed to",
            partial(time_parts, robots=robots, subscribed=subscribed),
        )
        for robots in (1, 100)
        for subscribed in (False, True)
    ),
    Case("run_office", "the office with its robot, in process, all subscribed to", run_office),
    Case("spawn", "a robot is spawned in the office, in process", spawn),
)

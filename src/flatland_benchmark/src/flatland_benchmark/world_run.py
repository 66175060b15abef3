"""Runs a world for some simulated time, and measures how long that takes.

It is the node flatland_server, with its topics, services and parameters, that ends by itself. A
program with rospy, it is imported only by the command that needs it.
"""

import time
from pathlib import Path
from typing import Callable, List

from flatland_server.hub import positive_param
from flatland_server.ros.launch_arguments import check_launch_arguments, parent_command_line
from flatland_server.ros.server import run_node
from flatland_server.ros.server_parameters import param
from flatland_server.simulation import SimulationManager

DURATION = 20.0
"""Simulated time by default [s]."""


def run_world(launch_files: List[Path]) -> int:
    """Runs the world of the node's parameters, and prints its speed. Returns the exit code.

    Raises:
        FlatlandError: the launch files do not have the arguments that they were given.
    """
    check_launch_arguments(launch_files, parent_command_line())

    def simulate(manager: SimulationManager, goes_on: Callable[[], bool]) -> None:
        duration = positive_param(param, "~benchmark_duration", DURATION)
        print(measure(manager, duration, goes_on))

    return run_node("flatland_benchmark", simulate)


def measure(manager: SimulationManager, duration: float, goes_on: Callable[[], bool]) -> str:
    """Runs a simulation, and says how fast it was.

    Args:
        manager: the simulation to run.
        duration: simulated time to run for [s].
        goes_on: called before each step; false ends the run early.
    """
    timekeeper = manager.timekeeper
    steps = 0

    def count() -> None:
        nonlocal steps
        steps += 1

    manager.after_step.append(count)
    begin, cpu = time.perf_counter(), time.process_time()
    manager.run(lambda: timekeeper.seconds < duration and goes_on())
    seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
    manager.after_step.remove(count)
    return (
        f"simulated {timekeeper.seconds:.6g} s in {seconds:.4g} s of real time: "
        f"{timekeeper.seconds / seconds:.4g} times real time; {steps} steps of "
        f"{seconds / max(steps, 1) * 1e6:.4g} us ({cpu / max(steps, 1) * 1e6:.4g} us of "
        "processor time)"
    )

"""Runs a world for some simulated time, and measures how long that takes.

It is the node flatland_server, with its topics, services and parameters, that ends by itself. A
program with rospy, it is imported only by the command that needs it.
"""

import time
from pathlib import Path
from typing import Callable, Optional

import rospy

from flatland_benchmark.case import Figures
from flatland_benchmark.report import CaseReport, Report
from flatland_server.ros.server import run_node
from flatland_server.ros.server_config import positive_param
from flatland_server.simulation.simulation_manager import SimulationManager

CASE = "world"
"""The name of the run in reports."""

DURATION = 20.0
"""Simulated time by default [s]."""


def run_world(json: Optional[Path]) -> int:
    """Runs the world of the node's parameters and prints its speed.

    Args:
        json: the file to write the figures to, if any.

    Returns:
        The exit code.
    """

    def simulate(manager: SimulationManager, goes_on: Callable[[], bool]) -> None:
        duration = positive_param("~benchmark_duration", DURATION)
        figures = measure(manager, duration, goes_on)
        print(in_words(figures), flush=True)
        if json is not None:
            report = Report.begin()
            world = rospy.get_param("~world_path")
            report.cases[CASE] = CaseReport.of_runs(f"the world {world}", [figures])
            json.write_text(report.to_json(), encoding="utf-8")

    return run_node("flatland_benchmark", simulate)


def measure(manager: SimulationManager, duration: float, goes_on: Callable[[], bool]) -> Figures:
    """Runs a simulation, and returns how fast it was.

    Args:
        manager: the simulation.
        duration: simulated time to run for [s].
        goes_on: false ends it earlier.
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
    return {
        "simulated [s]": timekeeper.seconds,
        "real time [s]": seconds,
        "times real time": timekeeper.seconds / seconds,
        "steps": steps,
        "step [us]": seconds / max(steps, 1) * 1e6,
        "CPU per step [us]": cpu / max(steps, 1) * 1e6,
    }


def in_words(figures: Figures) -> str:
    """The figures of a run, as text."""
    return (
        f"simulated {figures['simulated [s]']:.6g} s in {figures['real time [s]']:.4g} s of real "
        f"time: {figures['times real time']:.4g} times real time; {figures['steps']:.0f} steps of "
        f"{figures['step [us]']:.4g} us ({figures['CPU per step [us]']:.4g} us of processor time)"
    )

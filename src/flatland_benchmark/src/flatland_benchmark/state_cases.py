"""States of a simulation: branches, as a planner uses them, and the history of an hour's run."""

import statistics
import time
from pathlib import Path
from typing import Any, Callable

import numpy as np

from flatland2d import Simulation
from flatland_benchmark.batch_cases import office, warm_up
from flatland_benchmark.case import Figures, case

_BRANCHES = 1024
_COMMANDS = 20
"""Of a rollout."""
_SUBSTEPS = 10
"""Physics steps before the rollouts, for each of the robot's commands."""
_ROUNDS = 15
_SECONDS = 3600
_COMMAND_STEPS = 20
"""Steps of a run with a history between two commands: 0.1 s."""
_SEEKS = 100


@case("branches_{beams}", "1024 branches of the office, {beams} beams", beams=(64, 360))
def run_branches(worlds: Path, beams: int) -> Figures:
    """Branches of a drive through the office that drive on at random; each has a scan per step."""
    rng = np.random.default_rng(0)
    with Simulation(office(worlds, beams)) as sim:
        robot = sim.models["robot"]
        for turn in np.tile([0.4, -0.4], 20):
            robot.command(0.5, turn)
            sim.step(_SUBSTEPS)
        figures: Figures = {"save [ms]": _time(sim.save_state)}
        figures["branch [ms]"] = _time(lambda: sim.branch(_BRANCHES).close())
        state = sim.save_state()
        figures["state [KB]"] = len(state) / 1e3
        with sim.branch(_BRANCHES) as batch:
            warm_up(batch, rng)
            out = batch.observe()
            figures["load into all [ms]"] = _time(lambda: batch.load_states(state, out=out))
            actions = rng.uniform([0.0, -1.0], [0.6, 1.0], (_COMMANDS, _BRANCHES, 2))

            def roll_out() -> None:
                batch.load_states(state, out=out)
                for each in actions:
                    batch.step(each, 1, out=out)

            figures["branch steps/s"] = _BRANCHES * _COMMANDS / _time(roll_out) * 1e3
    return figures


def _time(function: Callable[[], Any]) -> float:
    """Median processor time of a call [ms]."""
    times = []
    for _ in range(_ROUNDS):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return statistics.median(times) * 1e3


@case("history", "an hour in the office with its history, and seeks")
def run_history(worlds: Path) -> Figures:
    """Drives about the office for an hour; then seeks random times."""
    with Simulation(office(worlds, 360)) as sim:
        without = _drive(sim)
        sim.reset()
        history = sim.keep_history()
        kept = _drive(sim)
        figures: Figures = {
            "CPU per simulated s [ms]": without / _SECONDS * 1e3,
            "CPU with a history [ms]": kept / _SECONDS * 1e3,
            "memory [MB]": history.size / 1e6,
        }
        seeks = []
        for sought in np.random.default_rng(1).uniform(0.0, history.end, _SEEKS):
            begin = time.process_time()
            sim.seek(sought)
            seeks.append((time.process_time() - begin) * 1e3)
        figures["seek, median [ms]"] = statistics.median(seeks)
        figures["seek, longest [ms]"] = max(seeks)
    return figures


def _drive(sim: Simulation) -> float:
    """Processor time of the drive [s]."""
    robot = sim.models["robot"]
    begin = time.process_time()
    for turn in np.random.default_rng(0).uniform(-1.0, 1.0, _SECONDS * 10):
        robot.command(0.5, turn)
        sim.step(_COMMAND_STEPS)
    return time.process_time() - begin

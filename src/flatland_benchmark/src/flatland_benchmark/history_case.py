"""The history of an hour's run: what keeping it costs, and going to its moments."""

import time
from pathlib import Path

import numpy as np

from flatland2d import Simulation
from flatland_benchmark.batch_cases import office
from flatland_benchmark.case import Case, Figures

_SECONDS = 3600
_COMMAND_STEPS = 20
"""Steps between two commands: 0.1 s."""
_SEEKS = 100


def run_history(worlds: Path) -> Figures:
    """Drives about the office for an hour; then goes to moments at random."""
    with Simulation(office(worlds, 360)) as sim:
        without = _drive(sim, np.random.default_rng(0))
        sim.reset()
        history = sim.keep_history()
        kept = _drive(sim, np.random.default_rng(0))
        figures: Figures = {
            "CPU per simulated second [ms]": without / _SECONDS * 1e3,
            "CPU with a history [ms]": kept / _SECONDS * 1e3,
            "memory [MB]": history.size / 1e6,
        }
        seeks = []
        for moment in np.random.default_rng(1).uniform(0.0, history.end, _SEEKS):
            begin = time.process_time()
            sim.seek(moment)
            seeks.append((time.process_time() - begin) * 1e3)
        figures["seek, median [ms]"] = float(np.median(seeks))
        figures["seek, longest [ms]"] = max(seeks)
    return figures


def _drive(sim: Simulation, rng: np.random.Generator) -> float:
    """Processor time of the drive [s]."""
    robot = sim.models["robot"]
    begin = time.process_time()
    for turn in rng.uniform(-1.0, 1.0, _SECONDS * 10):
        robot.command(0.5, turn)
        sim.step(_COMMAND_STEPS)
    return time.process_time() - begin


HISTORY_CASE = Case("history", "an hour in the office with its history, and seeks", run_history)

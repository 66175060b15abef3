"""Branches of a simulation: what a planner costs that tries commands in them."""

import statistics
import time
from functools import partial
from pathlib import Path
from typing import Any, Callable

import numpy as np

from flatland2d import Simulation
from flatland_benchmark.batch_cases import office, warm_up
from flatland_benchmark.case import Case, Figures

_BRANCHES = 1024
_COMMANDS = 20
"""Of a rollout."""
_SUBSTEPS = 10
"""Physics steps before the rollouts, for each of the robot's commands."""
_ROUNDS = 15


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


BRANCH_CASES = tuple(
    Case(
        f"branches_{beams}",
        f"{_BRANCHES} branches of the office, {beams} beams, rollouts of {_COMMANDS} steps",
        partial(run_branches, beams=beams),
    )
    for beams in (64, 360)
)

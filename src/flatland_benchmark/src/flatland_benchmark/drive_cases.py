"""Robots that drive about in the office, and meet each other and walls."""

import statistics
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import List

import numpy as np

from flatland2d import Simulation
from flatland_benchmark.case import Case, Figures
from flatland_benchmark.figures import in_words
from flatland_benchmark.robot_worlds import write_world

_ROBOTS = (1, 10, 100)
_STEPS = 100
"""Steps per block, after which each robot gets another command; a figure is a median of blocks."""
_BLOCKS = 40
_TIME_LIMIT = 8.0
"""Limit for all blocks of a figure [s of real time]; the rest is not measured."""
_SPEED = 1.0  # m/s, the greatest
_YAW_RATE = 1.5  # rad/s, the greatest


def drive(worlds: Path, robots: int) -> Figures:
    """This many robots, crowded at first, with random commands; and the same robots at rest."""
    with tempfile.TemporaryDirectory() as folder:
        path = write_world(Path(folder), worlds, robots, crowded=True)
        driving, resting = (Simulation(path, seed=1) for _ in range(2))
    rng = np.random.default_rng(1)
    times: List[float] = []
    ratios: List[float] = []
    touches: List[int] = []
    begin = time.perf_counter()
    while len(times) < _BLOCKS and time.perf_counter() < begin + _TIME_LIMIT:
        speeds = rng.uniform(-_SPEED / 2, _SPEED, robots)
        for robot, speed, rate in zip(
            driving.models.values(), speeds, rng.uniform(-_YAW_RATE, _YAW_RATE, robots)
        ):
            robot.command(speed, rate)
        times.append(_time_block(driving))
        ratios.append(times[-1] / _time_block(resting))
        touches.append(len(driving.contacts))
    driving.close()
    resting.close()
    return {
        "step [us]": statistics.median(times),
        "step per robot [us]": statistics.median(times) / robots,
        "times that at rest": statistics.median(ratios),
        "touches at a time": statistics.mean(touches),
    }


def _time_block(sim: Simulation) -> float:
    """Time of a step [us]."""
    begin = time.perf_counter()
    sim.step(_STEPS)
    return (time.perf_counter() - begin) / _STEPS * 1e6


DRIVE_CASES = tuple(
    Case(
        f"drive_{robots}",
        f"{in_words(robots)} in the office, driving about, in process, no subscribers",
        partial(drive, robots=robots),
    )
    for robots in _ROBOTS
)

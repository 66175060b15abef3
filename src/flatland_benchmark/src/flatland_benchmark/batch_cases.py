"""Batches of environments: SimulationBatch, in this process, without ROS."""

import math
import time
from pathlib import Path
from typing import Any, Dict

import numpy as np

from flatland2d import SimulationBatch
from flatland_benchmark.case import Figures, case

_CLEARANCE = 0.3
"""Clearance of the robots' starts [m]."""
_REACHED = 0.19
"""Distance from walls at which robots, of a radius of 0.18 m, are stopped [m]."""
_WARM_UP = 3000
"""Scans per square metre before the measurement. The core then knows the walls visible from each
cell of half a metre, even if robots reach only a quarter of it."""
_SCANS_FROM_A_POSE = 10
_MEASURED = 2.0
"""Least duration of a measurement [s of real time]."""
_BLOCK = 40_000
"""Steps per block, after each of which robots that have collided are put elsewhere."""


_PACES = {"1x50ms": (1, 0.05), "20x5ms": (20, 0.005)}
"""Physics steps in a step of an environment, and their size [s]."""


def office(worlds: Path, beams: int) -> Dict[str, Any]:
    """The content of the office's world file, with a lidar of so many beams all around."""
    folder = worlds / "office"
    increment = 2 * math.pi / beams
    plugins = [
        {"type": "DiffDrive", "name": "drive", "body": "base_link"},
        {
            "type": "Laser",
            "name": "laser",
            "body": "base_link",
            "origin": [0.05, 0, 0],
            "range": 20,
            "angle": {"min": -math.pi, "max": math.pi - increment, "increment": increment},
        },
    ]
    footprint = {"type": "circle", "radius": 0.18, "density": 38}
    robot = {"bodies": [{"name": "base_link", "footprints": [footprint]}], "plugins": plugins}
    boxes = [[6.0, -0.2, 0.3], [-4.5, 0.4, -0.5], [0.2, -5.0, 0.8], [-14.2, -6.8, 0.2]]
    return {
        "properties": {},
        "layers": [{"name": "map", "map": str(folder / "office.yaml")}],
        "models": [
            {"name": "robot", "model": robot},
            *(
                {"name": f"box{i}", "pose": pose, "model": str(folder / "box.model.yaml")}
                for i, pose in enumerate(boxes)
            ),
        ],
    }


@case(
    "batch_{count}_{beams}_{pace}",
    "{count} environments of the office, {beams} beams, steps of {pace}",
    count=(1, 64, 1024),
    beams=(64, 360),
    pace=tuple(_PACES),
)
@case(
    "batch_{count}_{beams}_{pace}_x{threads}",
    "{count} environments of the office, {beams} beams, steps of {pace}, {threads} threads",
    count=(1024,),
    beams=(360,),
    pace=tuple(_PACES),
    threads=(2,),
)
def run_batch(worlds: Path, count: int, beams: int, pace: str, threads: int = 1) -> Figures:
    """Environments with robots all over the office that drive at random until they collide."""
    before = proportional_memory()
    rng = np.random.default_rng(0)
    substeps, step_size = _PACES[pace]
    with SimulationBatch(
        office(worlds, beams), count, threads=threads, step_size=step_size
    ) as batch:
        spread(batch, rng)
        warm_up(batch, rng)
        spread(batch, rng)
        memory = proportional_memory() - before
        return {**measure(batch, substeps, rng), "memory [MB]": memory}


def spread(batch: SimulationBatch, rng: np.random.Generator) -> None:
    """Puts all robots at random poses."""
    batch.reset(poses=batch.free_poses(batch.num_envs, _CLEARANCE, rng))


def warm_up(batch: SimulationBatch, rng: np.random.Generator) -> None:
    """Scans from random places, so that the core has found the walls visible from each cell."""
    scans = int(_WARM_UP * batch.free_space(_REACHED).area)
    out = batch.observe()
    for _ in range(0, scans, _SCANS_FROM_A_POSE * batch.num_envs):
        poses = batch.free_poses(batch.num_envs, _REACHED, rng)
        batch.reset(poses=poses, out=out)
        for _ in range(_SCANS_FROM_A_POSE - 1):
            batch.observe(out=out)


def measure(batch: SimulationBatch, substeps: int, rng: np.random.Generator) -> Figures:
    """Steps all environments for a while; resets in between are not counted."""
    out = batch.observe()
    count, seconds, cpu = 0, 0.0, 0.0
    steps = max(1, _BLOCK // batch.num_envs // substeps)
    while seconds < _MEASURED:
        actions = rng.uniform([0.0, -1.0], [0.6, 1.0], (batch.num_envs, 2))
        begin, begin_cpu = time.perf_counter(), time.process_time()
        for _ in range(steps):
            batch.step(actions, substeps, out=out)
        cpu += time.process_time() - begin_cpu
        seconds += time.perf_counter() - begin
        count += steps * batch.num_envs
        if out.collided.any():
            poses = batch.free_poses(batch.num_envs, _CLEARANCE, rng)
            batch.reset(out.collided, poses=poses, out=out)
    return {
        "env steps/s": count / seconds,
        "CPU per env step [us]": cpu / count * 1e6,
    }


def proportional_memory() -> float:
    """Memory of this process [MB]; pages mapped several times count once."""
    lines = Path("/proc/self/smaps_rollup").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("Pss:"))

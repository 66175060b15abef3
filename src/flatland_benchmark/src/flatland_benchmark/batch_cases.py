"""Batches of environments: SimulationBatch, in this process, without ROS."""

import math
import time
from functools import partial
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Optional

import numpy as np

from flatland2d.batch.simulation_batch import SimulationBatch
from flatland_benchmark.case import Case, Figures
from flatland_server.arrays import BoolArray

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
"""Steps per block. The fastest block is reported too: other programs disturb it least."""


class Pace(NamedTuple):
    """The division of an environment's step into physics steps."""

    substeps: int
    step_size: float  # [s]

    @property
    def name(self) -> str:
        return f"{self.substeps}x{self.step_size * 1e3:g}ms"


_PACES = (Pace(1, 0.05), Pace(20, 0.005))


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


def run_batch(
    worlds: Path, count: int, beams: int, pace: Pace, threads: int, calls: int = 1
) -> Figures:
    """Environments with robots all over the office that drive at random until they collide.

    Each step is divided into `calls` masked calls, as if each part were in a world of its own.
    """
    before = proportional_memory()
    rng = np.random.default_rng(0)
    with SimulationBatch(
        office(worlds, beams), count, threads=threads, step_size=pace.step_size
    ) as batch:
        spread(batch, rng)
        warm_up(batch, rng)
        spread(batch, rng)
        memory = proportional_memory() - before
        figures = measure(batch, pace.substeps, rng, calls)
        return {**figures, "memory [MB]": memory, **time_resets(batch, rng)}


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


def measure(batch: SimulationBatch, substeps: int, rng: np.random.Generator, calls: int) -> Figures:
    """Steps all environments for a while; resets in between are not counted."""
    out = batch.observe()
    masks = masks_of(batch.num_envs, calls, rng)
    count, seconds, cpu, fastest = 0, 0.0, 0.0, math.inf
    steps = max(1, _BLOCK // batch.num_envs // substeps)
    while seconds < _MEASURED:
        actions = rng.uniform([0.0, -1.0], [0.6, 1.0], (batch.num_envs, 2))
        begin, begin_cpu = time.perf_counter(), time.process_time()
        for _ in range(steps):
            for mask in masks:
                batch.step(actions, substeps, out=out, mask=mask)
        block = time.process_time() - begin_cpu
        seconds += time.perf_counter() - begin
        cpu += block
        count += steps * batch.num_envs
        fastest = min(fastest, block / steps / batch.num_envs)
        if out.collided.any():
            poses = batch.free_poses(batch.num_envs, _CLEARANCE, rng)
            batch.reset(out.collided, poses=poses, out=out)
    return {
        "env steps/s": count / seconds,
        "env step [us]": seconds / count * 1e6,
        "CPU per env step [us]": cpu / count * 1e6,
        "fastest CPU per env step [us]": fastest * 1e6,
    }


def masks_of(count: int, parts: int, rng: np.random.Generator) -> List[Optional[BoolArray]]:
    """Masks that divide the environments at random into parts; None for a single part."""
    if parts == 1:
        return [None]
    part_of = rng.integers(parts, size=count)
    return [part_of == part for part in range(parts)]


def time_resets(batch: SimulationBatch, rng: np.random.Generator) -> Figures:
    """Processor time of resets, without their scans."""
    out = batch.observe()
    rounds = max(1, 2000 // batch.num_envs)
    poses = [batch.free_poses(batch.num_envs, _CLEARANCE, rng) for _ in range(rounds)]
    resets = observations = 0.0
    for each in poses:
        batch.step(np.full((batch.num_envs, 2), 0.3), 20, out=out)
        begin = time.process_time()
        batch.reset(poses=each, out=out)
        middle = time.process_time()
        batch.observe(out=out)
        resets += middle - begin
        observations += time.process_time() - middle
    return {"reset [us]": (resets - observations) / rounds / batch.num_envs * 1e6}


def proportional_memory() -> float:
    """Memory of this process [MB]; pages mapped several times count once."""
    for line in Path("/proc/self/smaps_rollup").read_text().splitlines():
        if line.startswith("Pss:"):
            return int(line.split()[1]) / 1024
    raise RuntimeError("/proc/self/smaps_rollup has no Pss")


def _case(count: int, beams: int, pace: Pace, threads: int, calls: int = 1) -> Case:
    name = f"batch_{count}_{beams}_{pace.name}" + ("_x2" if threads > 1 else "")
    name += "_masks" if calls > 1 else ""
    environments = "1 environment" if count == 1 else f"{count} environments"
    on = "2 threads" if threads > 1 else "1 thread"
    on += f", in {calls} calls with masks" if calls > 1 else ""
    return Case(
        name,
        f"{environments} of the office, {beams} beams, steps of {pace.name}, {on}",
        partial(run_batch, count=count, beams=beams, pace=pace, threads=threads, calls=calls),
    )


BATCH_CASES = (
    *(
        _case(count, beams, pace, 1)
        for count in (1, 64, 1024)
        for beams in (64, 360)
        for pace in _PACES
    ),
    *(_case(1024, 360, pace, 2) for pace in _PACES),
    *(_case(count, 64, _PACES[0], 1, calls=3) for count in (64, 1024)),
)

"""The office in a Python program: the cost of steps, of readings, and of threads."""

import hashlib
import statistics
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, List

import yaml

from flatland2d import Simulation
from flatland_benchmark.case import Case, Figures

_BEAMS = (64, 360, 1081)
_SELDOM = 20
"""Steps between two readings, in cases that do not read after each step."""
_STEPS = 400
"""Steps per block; a figure is the median of the blocks."""
_BLOCKS = 25
_FIELD_OF_VIEW = 4.71238898038469
"""Field of view of the lidar [rad]: 270 degrees."""
_SIMULATIONS = 64
_ROUNDS = 15


def open_office(worlds: Path, beams: int = 1081, seed: int = 0) -> Simulation:
    """The office with its robot, which drives in a circle; nothing is subscribed to.

    Args:
        worlds: the folder of flatland_server's worlds.
        beams: of its lidar.
        seed: of all random numbers.
    """
    folder = worlds / "office"
    model: Dict[str, Any] = yaml.safe_load((folder / "turtlebot.model.yaml").read_text())
    for plugin in model["plugins"]:
        if plugin["type"] == "Laser":
            half = _FIELD_OF_VIEW / 2
            plugin["angle"] = {"min": -half, "max": half, "increment": 2 * half / (beams - 1)}
    layers = [{"name": "map", "map": str(folder / "office.yaml")}]
    sim = Simulation({"properties": {}, "layers": layers}, seed=seed)
    sim.spawn(model, "turtlebot").command(0.5, 0.5)
    sim.step(_SELDOM)  # includes one-time work
    return sim


def time_step(sim: Simulation, read: Callable[[], Any], steps_per_reading: int) -> float:
    """Processor time of a step [us], with its share of the readings."""
    times = []
    for _ in range(_BLOCKS):
        begin = time.process_time()
        for _ in range(_STEPS // steps_per_reading):
            sim.step(steps_per_reading)
            read()
        times.append(time.process_time() - begin)
    return statistics.median(times) / _STEPS * 1e6


def read_nothing(worlds: Path) -> Figures:
    """Steps alone: many in a call, one in a call, and those of the core."""
    with open_office(worlds) as sim:
        core = []
        for _ in range(_BLOCKS):
            begin = time.process_time()
            sim.world.physics.step_until_contact(sim.step_size, _STEPS)
            core.append(time.process_time() - begin)
        return {
            "step(400) [us]": time_step(sim, lambda: None, _STEPS),
            "step(20) [us]": time_step(sim, lambda: None, 20),
            "step() [us]": time_step(sim, lambda: None, 1),
            "of the core [us]": statistics.median(core) / _STEPS * 1e6,
        }


def read_pose(worlds: Path) -> Figures:
    """Steps with readings of the robot's pose, or of all models' poses as an array."""
    with open_office(worlds) as sim:
        robot = sim.models["turtlebot"]
        return {
            "read at each step [us]": time_step(sim, lambda: robot.pose, 1),
            "at each 20th [us]": time_step(sim, lambda: robot.pose, _SELDOM),
            "array at each step [us]": time_step(sim, lambda: sim.poses, 1),
            "array at each 20th [us]": time_step(sim, lambda: sim.poses, _SELDOM),
        }


def read_scan(worlds: Path, beams: int) -> Figures:
    """Steps with readings of scans of this many beams."""
    with open_office(worlds, beams) as sim:
        laser = sim.models["turtlebot"].sensors["laser"]
        return {
            "read at each step [us]": time_step(sim, laser.read, 1),
            "at each 20th [us]": time_step(sim, laser.read, _SELDOM),
        }


def run_threads(worlds: Path, scans: bool, steps_per_call: int) -> Figures:
    """Many simulations in one thread and in two: the GIL is released in steps and scans.

    Two threads hand the GIL over at each call, so that calls of few steps gain less.
    Hashing, which releases the GIL too, is the reference for the gain from a second thread.
    """
    sims = [open_office(worlds, seed=seed) for seed in range(_SIMULATIONS)]
    hashed = bytes(_STEPS * 250)  # about as much work

    def run(sim: Simulation) -> None:
        laser = sim.models["turtlebot"].sensors["laser"]
        for _ in range(_STEPS // steps_per_call):
            sim.step(steps_per_call)
            if scans:
                laser.read()

    def do_hash(sim: Simulation) -> None:
        for _ in range(10):
            hashlib.sha256(hashed).digest()

    def time_round(pool: ThreadPoolExecutor, work: Callable[[Simulation], None]) -> float:
        """Time of the work for all simulations [s]."""
        begin = time.perf_counter()
        list(pool.map(work, sims))
        return time.perf_counter() - begin

    times: Dict[int, List[float]] = {1: [], 2: []}
    ratios: List[float] = []
    hashing: List[float] = []
    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(2) as two:
        for _ in range(_ROUNDS):  # in turn, so that other programs affect all alike
            times[1].append(time_round(one, run))
            times[2].append(time_round(two, run))
            ratios.append(times[1][-1] / times[2][-1])
            hashing.append(time_round(one, do_hash) / time_round(two, do_hash))
    for sim in sims:
        sim.close()
    steps = _STEPS * len(sims)
    return {
        "1 thread [us]": statistics.median(times[1]) / steps * 1e6,
        "2 threads [us]": statistics.median(times[2]) / steps * 1e6,
        "times as fast": statistics.median(ratios),
        "hashing, times as fast": statistics.median(hashing),
    }


def reset(worlds: Path, world: str) -> Figures:
    """Processor time of a reset of a world as it comes, after a step."""
    with Simulation(worlds / world / "world.yaml") as sim:
        sim.reset().reset()  # the first ones make what later ones use again
        times = []
        for _ in range(_BLOCKS):
            begin = time.process_time()
            for _ in range(_SELDOM):
                sim.step().reset()
            times.append(time.process_time() - begin)
    return {"step and reset [us]": statistics.median(times) / _SELDOM * 1e6}


def walk_crowd(worlds: Path, motion: str) -> Figures:
    """Processor time of a crowd of 200 that crosses a circle, as a share of a core."""
    circle = {"count": 200, "radius": 25}
    crowd = {"type": "Crowd", "name": "people", "motion": motion, "circle": circle}
    world = {"properties": {}, "layers": [{"name": "map"}], "plugins": [crowd]}
    with Simulation(world) as simulation:
        begin = time.process_time()
        simulation.step(round(30.0 / simulation.step_size))
        return {"share of a core [%]": (time.process_time() - begin) / 30.0 * 100.0}


LIBRARY_CASES = (
    *(
        Case(f"library_crowd_{motion}", f"200 people, {motion}", partial(walk_crowd, motion=motion))
        for motion in ("orca", "social_force")
    ),
    Case("library_nothing", "the office and its driven robot, nothing read", read_nothing),
    Case("library_pose", "the same, its pose read", read_pose),
    *(
        Case(
            f"library_{beams}", f"the same, scans of {beams} beams", partial(read_scan, beams=beams)
        )
        for beams in _BEAMS
    ),
    *(
        Case(f"library_reset_{world}", f"resets of the world {world}", partial(reset, world=world))
        for world in ("office", "test_room")
    ),
    Case(
        "library_threads_step",
        f"{_SIMULATIONS} offices in threads, nothing read",
        partial(run_threads, scans=False, steps_per_call=_SELDOM),
    ),
    Case(
        "library_threads_scan",
        f"{_SIMULATIONS} offices in threads, 1081 beams at each 20th step",
        partial(run_threads, scans=True, steps_per_call=_SELDOM),
    ),
    Case(
        "library_threads_scan_100",
        "the same, at each 100th step",
        partial(run_threads, scans=True, steps_per_call=100),
    ),
)

"""Measures Flatland: rosrun flatland_server flatland_benchmark, or scripts/bench.

Each run of a case is a process of its own, so that its memory is its own too. A busy machine gives
noisy times: compare medians within one call, and look at the spread.
"""

import argparse
import json
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable, Dict, List, Optional

import numpy as np
from PIL import Image

from flatland_server._core import BeamFan, Contact, ContactImpulse, Manifold
from flatland_server.model_plugin import ModelPlugin
from flatland_server.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.timekeeper import Timekeeper
from flatland_server.world import World
from flatland_server.yaml_reader import YamlReader

Figures = Dict[str, float]

_OFFICE = "office/world.yaml"


def load_large_map(worlds: Path, simplify_map: int = 0) -> Figures:
    """A noisy image of 4000 x 4000 pixels with several hundred thousand segments."""
    rng = np.random.default_rng(1)
    pixels = np.full((4000, 4000), 254, np.uint8)
    pixels[100:3900:200, 100:3900] = 0
    pixels[100:3900, 100:3900:200] = 0
    pixels[rng.random(pixels.shape) < 0.006] = 0
    with tempfile.TemporaryDirectory() as folder:
        Image.fromarray(pixels).save(f"{folder}/map.png")
        Path(folder, "map.yaml").write_text(
            "image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\n"
        )
        world_file = Path(folder, "world.yaml")
        world_file.write_text("properties: {}\nlayers: [{name: map, map: map.yaml}]\n")
        begin = time.perf_counter()
        world = World.from_file(world_file, simplify_map=simplify_map)
        seconds = time.perf_counter() - begin
    return {"segments": len(world.layers[0].segments), "load [s]": seconds, **_memory()}


def load_large_map_simplified(worlds: Path) -> Figures:
    """The same with outlines simplified moderately."""
    return load_large_map(worlds, simplify_map=1)


def scan_office(worlds: Path) -> Figures:
    """Scans of 1081 beams over 270 degrees and 20 m from free places in the office's corridor."""
    world = World.from_file(worlds / _OFFICE)
    fan = BeamFan(-2.356194490192345, 0.004363323129985824, 1081)
    rng = np.random.default_rng(1)
    poses = [(x, 0.0, yaw) for x, yaw in zip(rng.uniform(-25, 25, 500), rng.uniform(-3, 3, 500))]
    begin = time.perf_counter()
    for pose in poses:
        world.physics.scan(fan, pose, 20.0)
    seconds = time.perf_counter() - begin
    return {"beam [ns]": seconds / len(poses) / len(fan) * 1e9}


def run_office(worlds: Path) -> Figures:
    """The office with its robot, in this process, every topic listened to."""
    world = World.from_file(worlds / _OFFICE)
    timekeeper = Timekeeper(0.005)
    begin = time.perf_counter()
    while timekeeper.seconds < 60.0:
        world.step(timekeeper)
    return {"times real time": timekeeper.seconds / (time.perf_counter() - begin), **_memory()}


class Idle(ModelPlugin):
    """Overrides no hook."""

    def on_initialize(self, config: YamlReader) -> None:
        pass


class Listener(ModelPlugin):
    """Hears of every contact of its model, at every moment."""

    def on_initialize(self, config: YamlReader) -> None:
        pass

    def begin_contact(self, contact: Contact) -> None:
        pass

    def end_contact(self, contact: Contact) -> None:
        pass

    def pre_solve(self, contact: Contact, old_manifold: Manifold) -> None:
        pass

    def post_solve(self, contact: Contact, impulse: ContactImpulse) -> None:
        pass


def hear_contacts(worlds: Path) -> Figures:
    """A step of 100 discs that bounce about in a box, without plugins and with them."""
    loader = PluginLoader(
        PluginDeclaration(c.__name__, "benchmark", f"{__name__}.{c.__name__}")
        for c in (Idle, Listener)
    )
    return {
        "no plugins [us]": _bounce(loader, ""),
        "without hooks [us]": _bounce(loader, "plugins: [{type: Idle, name: plugin}]"),
        "with hooks [us]": _bounce(loader, "plugins: [{type: Listener, name: plugin}]"),
    }


def _bounce(loader: PluginLoader, plugins: str) -> float:
    """Microseconds of a step of the discs, each with these plugins."""
    disc = "{type: circle, radius: 0.2, density: 1, restitution: 1}"
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "disc.yaml").write_text(
            f"bodies: [{{name: disc, footprints: [{disc}]}}]\n{plugins}\n"
        )
        Path(folder, "box.dat").write_text("0 0 6 0\n6 0 6 6\n6 6 0 6\n0 6 0 0\n")
        Path(folder, "box.yaml").write_text(
            "{type: line_segments, data: box.dat, scale: 1, origin: [0, 0, 0]}"
        )
        poses = [f"[{0.6 + i % 10 / 2}, {0.6 + i // 10 / 2}, 0]" for i in range(100)]
        models = "".join(
            f"\n  - {{name: m{i}, model: disc.yaml, pose: {pose}}}" for i, pose in enumerate(poses)
        )
        path = Path(folder, "world.yaml")
        path.write_text(
            f"properties: {{}}\nlayers: [{{name: box, map: box.yaml}}]\nmodels:{models}"
        )
        world = World.from_file(path, loader=loader)
    rng = np.random.default_rng(1)
    for model in world.models.values():
        vx, vy = rng.uniform(-2, 2, 2)
        model.base.physics_body.velocity = (vx, vy, 0.0)
    timekeeper = Timekeeper(0.005)
    steps = 2000
    begin = time.perf_counter()
    for _ in range(steps):
        world.step(timekeeper)
    seconds = time.perf_counter() - begin
    world.close()
    return seconds / steps * 1e6


CASES: Dict[str, Callable[[Path], Figures]] = {
    case.__name__: case
    for case in (
        load_large_map,
        load_large_map_simplified,
        scan_office,
        run_office,
        hear_contacts,
    )
}


def _memory() -> Figures:
    return {"memory [MB]": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}


def measure(name: str, worlds: Path, runs: int) -> Dict[str, List[float]]:
    """The figures of a case, each with its values over the runs."""
    figures: Dict[str, List[float]] = {}
    for _ in range(runs):
        output = subprocess.run(
            [sys.executable, "-m", "flatland_server.benchmark", "--one", name, str(worlds)],
            stdout=subprocess.PIPE,
            check=True,
        ).stdout
        for figure, value in json.loads(output).items():
            figures.setdefault(figure, []).append(value)
    return figures


def main(arguments: Optional[List[str]] = None) -> int:
    """The command. Returns its exit code."""
    parser = argparse.ArgumentParser(prog="flatland_benchmark", description="Measure Flatland.")
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)}")
    parser.add_argument("--runs", type=int, default=5, help="of each case (default 5)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all values there too")
    parser.add_argument("--one", nargs=2, metavar=("CASE", "WORLDS"), help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.one:
        name, folder = options.one
        print(json.dumps(CASES[name](Path(folder))))
        return 0
    unknown = [name for name in options.cases if name not in CASES]
    if unknown or options.runs < 1:
        parser.error(f"unknown case {unknown[0]}" if unknown else "--runs: expected 1 or more")

    import rospkg

    worlds = Path(rospkg.RosPack().get_path("flatland_server")) / "worlds"
    results = {}
    print(f"{'case':28}{'figure':18}{'median':>12}{'least':>12}{'most':>12}")
    for name in options.cases or CASES:
        results[name] = measure(name, worlds, options.runs)
        for figure, values in results[name].items():
            numbers = (statistics.median(values), min(values), max(values))
            print(f"{name:28}{figure:18}" + "".join(f"{number:12.4g}" for number in numbers))
    if options.json:
        machine = {"system": platform.platform(), "processor": platform.machine()}
        options.json.write_text(json.dumps({"machine": machine, "cases": results}, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())

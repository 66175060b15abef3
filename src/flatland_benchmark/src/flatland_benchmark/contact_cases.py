"""The cost of contact hooks."""

import tempfile
import time
from pathlib import Path

import numpy as np

from flatland_benchmark.case import Case, Figures
from flatland_server._core import Contact, ContactImpulse, Manifold
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper


class Idle(ModelPlugin):
    """Overrides no hook."""

    def on_initialize(self, config: YamlReader) -> None:
        pass


class Hooked(ModelPlugin):
    """Overrides all contact hooks."""

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
    """A step of 100 discs bouncing in a box: without plugins, without hooks, with hooks."""
    loader = PluginLoader(map(PluginDeclaration.of, (Idle, Hooked)))
    return {
        "no plugins [us]": _bounce(loader, ""),
        "without hooks [us]": _bounce(loader, "plugins: [{type: Idle, name: plugin}]"),
        "with hooks [us]": _bounce(loader, "plugins: [{type: Hooked, name: plugin}]"),
    }


def _bounce(loader: PluginLoader, plugins: str) -> float:
    """Time of a step [us], each disc with these plugins."""
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
    run = Run(world, Timekeeper(0.005))
    steps = 2000
    begin = time.perf_counter()
    for _ in range(steps):
        run.step()
    seconds = time.perf_counter() - begin
    run.close()
    return seconds / steps * 1e6


CONTACT_CASES = (Case("hear_contacts", "a step of 100 discs bouncing in a box", hear_contacts),)

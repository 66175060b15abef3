"""Shared by the tests of contacts: plugins that record their calls, and a room with a wall."""

import math
from typing import Any, Callable, Dict, List, Tuple

import numpy as np

from flatland_server.geometry import Pose
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.simulation.world import WorldPlugin

DT = 0.005
RADIUS = 0.1
MASS = 10.0 * math.pi * RADIUS**2  # kg
INERTIA = 0.5 * MASS * RADIUS**2  # kg m^2
DISC = f"{{type: circle, radius: {RADIUS}, density: 10}}"
BOUNCING = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: 1}}"
SQUARE = "{type: polygon, points: [[-.2, -.2], [.2, -.2], [.2, .2], [-.2, .2]], density: 10}"


calls: List[Tuple[Any, ...]] = []
"""The calls so far: (plugin, hook, arguments of the hook ...)."""

actions: Dict[str, Callable[..., None]] = {}
"""The plugins' actions by name of the hook; called with the plugin and the hook's arguments."""


def _recorded(hook: str) -> Callable[..., None]:
    def call(self, *arguments: Any) -> None:
        calls.append((self.label, hook, *arguments))
        actions.get(hook, lambda *_: None)(self, *arguments)

    return call


class _Hooks:
    """Records the calls of its hooks, and runs the `actions` of the test."""

    def on_initialize(self, config):
        self.label = f"{self.model.name}/{self.name}" if hasattr(self, "model") else self.name

    before_physics_step = _recorded("before_physics_step")
    begin_contact = _recorded("begin_contact")
    pre_solve = _recorded("pre_solve")
    end_contact = _recorded("end_contact")
    post_solve = _recorded("post_solve")
    after_physics_step = _recorded("after_physics_step")


class Listener(_Hooks, ModelPlugin):
    pass


class WorldListener(_Hooks, WorldPlugin):
    pass


class OnlyBegin(ModelPlugin):
    def on_initialize(self, config):
        pass

    def begin_contact(self, contact):
        calls.append((f"{self.model.name}/{self.name}", "begin_contact", contact))


class NoContactHooks(ModelPlugin):
    """Has hooks, but no contact hooks."""

    def on_initialize(self, config):
        pass

    def before_physics_step(self, timekeeper):
        pass


class Room:
    """A world with a wall along x = 1, and models that move."""

    def __init__(self, files, simulate, plugins: str = "[]") -> None:
        self._files = files
        text = f"properties: {{}}\nlayers: [{{name: walls}}]\nplugins: {plugins}\n"
        self.world = files.load(text)
        self.simulation = simulate(self.world, DT)
        self.add_wall(1.0, -5.0, 1.0, 5.0)

    def add_wall(self, *ends: float) -> None:
        self.world.add_walls("walls", np.array([ends]))

    def put(self, name: str, pose, velocity=(0.0, 0.0, 0.0), plugins="", footprints=DISC):
        """Spawns a model with one body, "base"; plugins are given as "type | type"."""
        entries = "".join(
            f"\n  - {{type: {type.strip()}, name: p{i}}}"
            for i, type in enumerate(plugins.split("|"))
            if type.strip()
        )
        bodies = f"bodies: [{{name: base, footprints: [{footprints}]}}]\n"
        path = self._files.write(f"{name}.yaml", f"{bodies}plugins:{entries or ' []'}\n")
        model = self.world.spawn_model(path, name, "", Pose(*pose))
        model.base.physics_body.velocity = velocity
        return model

    def run(self, seconds=None):
        self.simulation.run(seconds)

    def run_until(self, hook: str) -> None:
        """Steps until a hook is called, and to the end of that step."""
        for _ in range(1000):
            calls.clear()
            self.run()
            if hook in called_hooks():
                return
        raise AssertionError(f"{hook} was not called")


def called_hooks(label: str = "") -> List[str]:
    """The hooks called so far, of one plugin or of all."""
    return [hook for plugin, hook, *_ in calls if label in ("", plugin)]

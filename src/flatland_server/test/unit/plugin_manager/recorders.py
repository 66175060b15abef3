"""Shared by the tests of the plugin manager: plugins that record their calls, and worlds."""

import math
from typing import Any, Callable, List, Tuple

from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import WorldPlugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.update_timer import UpdateTimer

DISC = "{type: circle, radius: 0.1, density: 1, restitution: 1}"
BODY = f"bodies: [{{name: base, footprints: [{DISC}]}}]\n"

calls: List[Tuple[Any, ...]] = []
"""The calls so far: (plugin, hook, ...)."""


class Recorder(ModelPlugin):
    """Records its calls, with the time [ns]; may fail in one of its hooks."""

    def on_initialize(self, config):
        self._fails_in = config.get_string("fails_in", "")
        self._exits = config.get_bool("exits", False)
        self.update_timer = UpdateTimer(config.get_rate("update_rate", math.inf))
        self.node.advertise(f"{self.model.name}/{self.name}", str)
        self.node.subscribe("command", str, lambda _: self._record("callback"))
        self.node.claim_frame("map", f"{self.model.name}/{self.name}")
        self._record("on_initialize")

    def before_physics_step(self, timekeeper):
        self._record("before", timekeeper.nanoseconds)

    def after_physics_step(self, timekeeper):
        self._record("after", timekeeper.nanoseconds)

    def on_shutdown(self):
        self._record("on_shutdown")

    def _record(self, hook: str, *more: Any) -> None:
        calls.append((f"{self.model.name}/{self.name}", hook, *more))
        if hook == self._fails_in:
            raise SystemExit("no luck") if self._exits else RuntimeError("no luck")


def _recorded(hook: str) -> Callable[..., None]:
    return lambda self, *_: self._record(hook)


class Toucher(Recorder):
    """Records its contacts too."""

    begin_contact, end_contact = _recorded("begin_contact"), _recorded("end_contact")
    pre_solve, post_solve = _recorded("pre_solve"), _recorded("post_solve")


class WorldRecorder(WorldPlugin):
    def on_initialize(self, config):
        self._fails = config.get_bool("fails", False)
        calls.append((self.name, "on_initialize", sorted(self.world.models)))

    def before_physics_step(self, timekeeper):
        calls.append((self.name, "before", timekeeper.nanoseconds))
        if self._fails:
            raise RuntimeError("no luck")

    def after_physics_step(self, timekeeper):
        calls.append((self.name, "after", timekeeper.nanoseconds))

    def on_shutdown(self):
        calls.append((self.name, "on_shutdown"))


class OnlyAfter(ModelPlugin):
    def on_initialize(self, config):
        pass

    def after_physics_step(self, timekeeper):
        calls.append((self.name, "after"))


class Dice(ModelPlugin):
    """Records random numbers when it starts."""

    def on_initialize(self, config):
        calls.append((f"{self.model.name}/{self.name}", tuple(self.rng.integers(1000, size=4))))


class Unfinished(ModelPlugin):
    pass


def world_of(files, models: str, plugins: str = "[]", **options: Any):
    """A world with models, given as "name: plugin | plugin; name: ..."."""
    entries = ""
    for model in models.split(";"):
        name, _, its_plugins = model.partition(":")
        write_model(files, name.strip(), its_plugins)
        entries += f"\n  - {{name: {name.strip()}, model: {name.strip()}.yaml}}"
    text = f"properties: {{}}\nlayers: []\nplugins: {plugins}\nmodels:{entries}"
    return files.load(text, **options)


def write_model(files, name: str, plugins: str):
    """Writes a model file with these plugins, one per line, beginning with line 3."""
    lines = "".join(
        f"\n  - {{{plugin.strip()}}}" for plugin in plugins.split("|") if plugin.strip()
    )
    return files.write(f"{name}.yaml", f"{BODY}plugins:{lines or ' []'}\n")


def step(world, count: int = 1) -> None:
    Run(world, Timekeeper(0.005)).step(count)


def hooks_of(plugin: str) -> List[str]:
    """The hooks called so far of one plugin."""
    return [hook for name, hook, *_ in calls if name == plugin]


def local(world) -> LocalTransport:
    assert isinstance(world.transport, LocalTransport)
    return world.transport

"""Shared by the tests of deferred changes: a world with plugins that do what a test plans."""

from collections import Counter
from typing import Any, Callable, Dict, Tuple

import numpy as np
import pytest

from flatland_server import _core
from flatland_server.exceptions import ModelError
from flatland_server.geometry import Pose
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.simulation.world import WorldPlugin

HOOKS = (
    *("before_physics_step", "begin_contact", "pre_solve"),
    *("post_solve", "end_contact", "after_physics_step"),
)
FAR = Pose(-3.0, 2.0, 0.5)

plans: Dict[Tuple[str, str], Callable[[], None]] = {}
"""The action of a model's plugin in its next call of a hook, by (model, hook)."""

starts: "Counter[str]" = Counter()
ends: "Counter[str]" = Counter()
"""The numbers of starts and shutdowns of each model's plugins."""


def _acts_in(hook: str) -> Callable[..., None]:
    return lambda self, *_: self._act(hook)


class Actor(ModelPlugin):
    """Runs the plans for its hooks."""

    def on_initialize(self, config):
        starts[self.model.name] += 1
        self.node.advertise(f"{self.model.name}/{self.name}", str)
        self.node.subscribe("cue", str, lambda _: self._act("callback"))
        self.node.claim_frame("map", f"{self.model.name}/{self.name}")
        self._act("on_initialize")
        if config.get_bool("fails", False):
            raise config.error("no luck")

    before_physics_step, begin_contact, pre_solve = map(_acts_in, HOOKS[:3])
    post_solve, end_contact, after_physics_step = map(_acts_in, HOOKS[3:])

    def on_shutdown(self):
        ends[self.model.name] += 1
        self._act("on_shutdown")

    def _act(self, hook: str) -> None:
        plan = plans.pop((self.model.name, hook), None)
        if plan is not None:
            plan()


class Founder(WorldPlugin):
    """Spawns a model when the world is created."""

    def on_initialize(self, config):
        self.founded = self.world.spawn_model(config.get_path("model"), "founded", "", Pose())


class Stage:
    """A world in which "robot" is about to bounce off "post"; "bystander" touches nothing."""

    def __init__(self, files, simulate) -> None:
        self.files = files
        ball = "{type: circle, radius: 0.1, density: 1, restitution: 1}"
        square = "{type: polygon, points: [[0, -1], [1, -1], [1, 1], [0, 1]], density: 1}"
        plugin = "plugins: [{type: Actor, name: actor}]"
        body = f"bodies: [{{name: base, footprints: [{ball}]}}]\n"
        static = f"bodies: [{{name: base, type: static, footprints: [{square}]}}]\n"
        bad = [f"\n  - {{type: Actor, name: {each}}}" for each in ("a", "b", "c, fails: true")]
        files.write("ball.yaml", body + plugin)
        files.write("post.yaml", static + plugin)
        files.write("bad.yaml", f"{body}plugins:{''.join(bad)}\n")
        self.world = files.load("properties: {}\nlayers: [{name: walls}]\n")
        self.world.add_walls("walls", np.array([[-9.0, -9.0, 9.0, -9.0]]))
        self.simulation = simulate(self.world)
        self.spawn("robot", Pose(0.8, 0.0, 0.0)).base.physics_body.velocity = (2.0, 0.0, 0.0)
        self.spawn("post", Pose(1.0, 0.0, 0.0), "post.yaml")
        self.spawn("bystander", Pose(-1.0, 0.0, 0.0))

    def spawn(self, name: str, pose: Pose = FAR, model: str = "ball.yaml"):
        return self.world.spawn_model(self.files.folder / model, name, "", pose)

    def body(self, name: str) -> _core.Body:
        return self.world.get_model(name).base.physics_body

    def cue(self) -> None:
        """Sends a message to all plugins, whose callbacks are run."""
        self.simulation.transport.send("/cue", "go")
        self.simulation.transport.process()

    def run(self, seconds=None) -> None:
        self.simulation.run(seconds)

    def run_until_done(self) -> None:
        """Steps until all plans have been run, and to the end of that step."""
        for _ in range(100):
            self.run()
            if not plans:
                return
        raise AssertionError(f"these hooks were not called: {list(plans)}")

    def check(self) -> None:
        """There is nothing but the models, and the plugins of all others were shut down once."""
        world = self.world
        assert world.physics.body_count == 1 + len(world.models)  # 1 for the wall
        assert len(list(world.entities)) == 1 + len(world.models)
        topics = {f"/{name}/actor" for name in world.models}
        assert self.simulation.transport.topics == topics
        assert self.simulation.transport.subscribed == ({"/cue"} if world.models else set())
        assert starts - ends == Counter(world.models.keys())
        assert ends - starts == Counter()
        assert world.plugin_failures == []


def refusal(ask: Callable[[], Any], kind=ModelError) -> str:
    with pytest.raises(kind) as caught:
        ask()
    return str(caught.value)

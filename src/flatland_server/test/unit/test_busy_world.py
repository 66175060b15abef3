"""A crowded world with random actions, in hooks and between steps."""

import random
from collections import Counter
from functools import lru_cache
from pathlib import Path
from typing import Any, Callable, Dict, List

import numpy as np
import pytest

from flatland_server import _core
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.world import World, WorldPlugin

pytestmark = pytest.mark.slow

DISC = "{type: circle, radius: 0.12, density: 1, restitution: 0.8, friction: 0.5}"
SQUARE = "{type: polygon, points: [[-.1, -.1], [.1, -.1], [.1, .1], [-.1, .1]], density: 2}"
PLUGINS = "plugins:\n  - {type: RandomPlugin, name: a}\n  - {type: RandomPlugin, name: b}\n"
MODELS = {
    "disc.yaml": f"bodies: [{{name: base, footprints: [{DISC}]}}]\n{PLUGINS}",
    "post.yaml": f"bodies: [{{name: base, type: static, footprints: [{SQUARE}]}}]\n{PLUGINS}",
    "ghost.yaml": f"bodies: [{{name: base, footprints: [{DISC[:-1]}, sensor: true}}]}}]\n{PLUGINS}",
    "train.yaml": f"""
bodies:
  - {{name: engine, footprints: [{DISC}]}}
  - {{name: wagon, pose: [0.25, 0, 0], footprints: [{SQUARE}]}}
joints:
  - type: revolute
    name: coupling
    bodies: [{{name: engine, anchor: [0.125, 0]}}, {{name: wagon, anchor: [-0.125, 0]}}]
{PLUGINS}""",
    "bad.yaml": f"bodies: [{{name: base, footprints: [{DISC}]}}]\n{PLUGINS}"
    "  - {type: Failing, name: c}\n",
}
MOST_MODELS = 20


class RandomActions:
    """Random actions, of plugins in their hooks and of the test between steps."""

    def begin(self, seed: int, world: World, folder: Path) -> None:
        self.rng = random.Random(seed)
        self.world = world
        self.bodies: List[_core.Body] = []
        """Of the models that exist, and of those that are deleted."""
        self.plugins: List[RandomPlugin] = []
        """All that have started, also those of deleted models."""
        self.done: Counter[str] = Counter()
        self.failed_checks: List[str] = []
        self._folder = folder
        self._spawned = 0

    def expect(self, condition: bool, what: str) -> None:
        """Records a failed check; an exception in a hook would only switch off the plugin."""
        if not condition:
            self.failed_checks.append(what)

    def maybe_act(self, probability: float) -> None:
        """Does something random, with this probability."""
        if self.rng.random() > probability:
            return
        action = self.rng.choice(
            [self.spawn, self.spawn, self.delete, self.move, self.push, self.look]
        )
        try:
            action()
        except (FlatlandError, _core.GoneError) as error:
            self.done[type(error).__name__] += 1
            for line in str(error).splitlines():
                self.expect("does not start" not in line or line.endswith(": at random"), line)
        self.done[action.__name__] += 1

    def spawn(self) -> None:
        if len(self.world.models) < MOST_MODELS:
            self._spawned += 1
            name = f"m{self.rng.choice([self._spawned, self._spawned - 1])}"
            path = self._folder / self.rng.choice(sorted(MODELS))
            self.world.spawn_model(path, name, "", self._pose())

    def delete(self) -> None:
        self.world.delete_model(self._name())

    def move(self) -> None:
        self.world.move_model(self._name(), self._pose())

    def push(self) -> None:
        body = self._body()
        body.velocity = (self.rng.uniform(-3, 3), self.rng.uniform(-3, 3), 1.0)
        body.apply_linear_impulse((0.01, 0.01))

    def look(self) -> None:
        body = self._body()
        values = [*body.pose, *body.velocity, body.fixtures[0].density]
        self.expect(bool(np.all(np.isfinite(values))), f"a body is at {values}")

    def _body(self) -> _core.Body:
        if not self.bodies:
            raise FlatlandError("there is no body yet")
        return self.rng.choice(self.bodies)

    def _name(self) -> str:
        return self.rng.choice([*self.world.models, "unknown"])

    def _pose(self) -> Pose:
        if self.rng.random() < 0.02:
            return Pose(1e6, 0.0, 0.0)
        return Pose(*(self.rng.uniform(-0.8, 0.8) for _ in range(2)), self.rng.uniform(-3, 3))


actions = RandomActions()


class RandomPlugin(ModelPlugin):
    """Does random actions in all its hooks, and fails sometimes."""

    def on_initialize(self, config):
        self.ends = 0
        actions.bodies += self.model.physics_bodies
        self.node.advertise(f"{self.model.name}/{self.name}", str)
        self.node.subscribe("cue", str, lambda _: self._act(0.1))
        self._act(0.2)
        actions.plugins.append(self)

    def before_physics_step(self, timekeeper):
        self._act(0.02)

    def begin_contact(self, contact):
        self._look_at(contact)
        self._act(0.1)

    def pre_solve(self, contact, old_manifold):
        if actions.rng.random() < 0.1:
            contact.set_enabled(False)
        self._act(0.01)

    def post_solve(self, contact, impulse):
        self._look_at(contact)
        self._act(0.01)

    def end_contact(self, contact):
        self._look_at(contact)
        self._act(0.1)

    def after_physics_step(self, timekeeper):
        self._act(0.02)

    def on_shutdown(self):
        self.ends += 1
        actions.maybe_act(0.2)

    def _look_at(self, contact: _core.Contact) -> None:
        sides = self.filter_contact(contact)
        actions.expect(sides is not None, "a contact of other models is reported")
        actions.expect(sides.this_fixture.body in self.model.physics_bodies, "the wrong side")
        actions.expect(bool(sides.entity.body_name(sides.other_fixture)), "the wrong entity")

    def _act(self, probability: float) -> None:
        actions.expect(self.ends == 0, f"{self.model.name}/{self.name} is called after on_shutdown")
        actions.maybe_act(probability)
        if actions.rng.random() < 0.001:
            raise RuntimeError("at random")


class Failing(ModelPlugin):
    def on_initialize(self, config):
        raise config.error("no luck")


class ContactChecker(WorldPlugin):
    """Checks that every contact begins before it is solved, and ends once."""

    def on_initialize(self, config):
        self.going: Dict[Any, Any] = {}

    def begin_contact(self, contact):
        assert contact not in self.going
        self.going[contact] = {contact.fixture_a, contact.fixture_b}

    def pre_solve(self, contact, old_manifold):
        assert self.going[contact] == {contact.fixture_a, contact.fixture_b}

    def post_solve(self, contact, impulse):
        assert self.going[contact] == {contact.fixture_a, contact.fixture_b}

    def end_contact(self, contact):
        assert self.going.pop(contact) == {contact.fixture_a, contact.fixture_b}


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of this file."""
    return PluginLoader(map(PluginDeclaration.of, (RandomPlugin, Failing, ContactChecker)))


@pytest.fixture
def make_world(files) -> Callable[[int], World]:
    """Makes a room of 2 m by 2 m, with random actions that depend on a seed."""

    def make(seed: int) -> World:
        for name, text in MODELS.items():
            files.write(name, text)
        plugins = "[{type: ContactChecker, name: checker}]"
        world = files.load(
            f"properties: {{}}\nlayers: [{{name: walls}}]\nplugins: {plugins}\n", seed=seed
        )
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
        world.add_walls("walls", np.hstack([corners[:-1], corners[1:]]))
        world.read_model = lru_cache(maxsize=None)(world.read_model)  # it takes most of the time
        actions.begin(seed, world, files.folder)
        while len(world.models) < MOST_MODELS:
            actions.maybe_act(1.0)
        return world

    return make


def check(world: World) -> None:
    """Everything that should exist does, and nothing else."""
    models = world.models
    assert world.physics.body_count == 1 + sum(len(m.bodies) for m in models.values())
    assert world.physics.joint_count == sum(len(m.joints) for m in models.values())
    assert set(world.entities) == {*world.layers, *models.values()}
    assert all(body.alive for m in models.values() for body in m.physics_bodies)
    failed = {failure.label for failure in world.plugin_failures}
    living = {f"{name}/{p}" for name, m in models.items() for p in ("a", "b")} - failed
    assert world.transport.topics == {f"/{label}" for label in living}
    for plugin in actions.plugins:
        is_there = models.get(plugin.model.name) is plugin.model
        is_alive = is_there and f"{plugin.model.name}/{plugin.name}" not in failed
        assert plugin.ends == (0 if is_alive else 1)
    assert "checker" not in failed
    assert actions.failed_checks == []


@pytest.mark.parametrize("seed", range(8))
def test_nothing_is_lost_or_left_over_after_random_actions(make_world, simulate, seed, caplog):
    world = make_world(seed)
    simulation = simulate(world)

    for _ in range(150):
        actions.maybe_act(0.3)
        if actions.rng.random() < 0.1:
            simulation.transport.send("/cue", "go")
        simulation.run()
        check(world)
    for name in list(world.models):
        if name in world.models:
            world.delete_model(name)
            check(world)
    world.close()

    assert simulation.transport.topics == set()
    assert simulation.transport.subscribed == set()
    assert min(actions.done[action] for action in ("spawn", "delete", "move", "push", "look")) > 20
    assert actions.done["GoneError"] > 3
    raised = {str(record.exc_info[1]) for record in caplog.records if record.exc_info}
    assert raised <= {"at random"}


def test_equal_seeds_and_actions_give_equal_worlds(make_world, simulate):
    def run() -> Dict[str, Any]:
        world = make_world(3)
        simulation = simulate(world)
        for _ in range(100):
            actions.maybe_act(1.0)
            simulation.run()
        return {name: model.base.physics_body.pose for name, model in world.models.items()}

    assert run() == run()

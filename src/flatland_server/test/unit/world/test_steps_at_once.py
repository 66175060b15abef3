"""Steps in one call of the core, which plugins cannot tell from single ones."""

import math
import random
from typing import Any, List

import pytest

from flatland_server.geometry import Pose
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import World
from flatland_server.testing import WorldFiles
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.transport import Transport
from flatland_server.update_timer import UpdateTimer

WALLS = ("0 0 3 0", "3 0 3 3", "3 3 0 3", "0 3 0 0")
DISC = "{type: circle, radius: 0.15, density: 1, restitution: 1}"


class Witnessed(Run):
    """A run, and what its plugins have seen; they share it as `run`."""

    def __init__(self, world: World) -> None:
        super().__init__(world, Timekeeper(0.005))
        self.log: List[Any] = []
        self.calls = 0

    def make(self, count: int, at_once: bool) -> "Witnessed":
        global run
        run = self
        while count > 0:
            self.transport.process()
            self.calls += 1
            if at_once:
                count -= self._step_up_to(count)
            else:
                self._step_with_hooks()
                count -= 1
        return self

    def seen(self) -> Any:
        poses = [model.base.pose for model in self.world.models.values()]
        return self.log, poses, self.timekeeper.nanoseconds


run: Witnessed


class Witness(ModelPlugin):
    """Logs contacts and their times, and acts at some of them."""

    def on_initialize(self, config):
        self.count = 0

    def begin_contact(self, contact):
        run.log.append((run.timekeeper.nanoseconds, self.model.name, contact.normal))
        self.count += 1
        if self.count % 3 == 0:
            run.world.move_model(self.model.name, Pose(*(0.5 + self.rng.random(2) * 2), 0.0))
        if self.count % 4 == 0:
            self.model.base.physics_body.velocity = (*self.rng.uniform(-3, 3, 2), 1.0)
        if self.count % 5 == 0:
            self.update_timer = UpdateTimer(self.rng.uniform(10, 100))
        if self.count == 12:
            raise ValueError("enough")

    def end_contact(self, contact):
        run.log.append((run.timekeeper.nanoseconds, self.model.name, "end"))
        run.world.transport.send("/cue", self.model.name)

    def get_state(self):
        return self.count


class Timed(ModelPlugin):
    """Logs the times of its updates, and its messages."""

    def on_initialize(self, config):
        self.update_timer = UpdateTimer(config.get_float("rate"))
        self.node.subscribe("cue", str, self.hear)

    def hear(self, cue):
        run.log.append((run.timekeeper.nanoseconds, self.name, cue))

    def before_physics_step(self, timekeeper):
        run.log.append((timekeeper.nanoseconds, self.name, tuple(self.model.base.pose)))

    def get_state(self):
        return None


class Announcer(Timed):
    """Works for subscribers only."""

    def on_initialize(self, config):
        super().on_initialize(config)
        self.publisher = self.node.advertise("news", str)

    def has_work(self):
        return self.publisher.has_subscribers


@pytest.fixture
def files(tmp_path) -> WorldFiles:
    plugins = (Witness, Timed, Announcer)
    return WorldFiles(tmp_path, PluginLoader(map(PluginDeclaration.of, plugins)))


def make_run(files: WorldFiles, *plugins: str, transport: Any = None, seed: int = 0) -> Witnessed:
    """Discs that bounce in a room; the first has these plugins, the others none."""
    files.model("plain", footprint=DISC)
    files.model("first", *plugins, footprint=DISC)
    models = {
        f"m{i}": {"model": f"{'plain' if i else 'first'}.model.yaml", "pose": [0.5 + i / 3, 1.5, 0]}
        for i in range(6)
    }
    layers = [{"name": "room", "map": files.walls("room", *WALLS)}]
    transport = transport or LocalTransport(subscribed_topics=())
    simulation = files.load_models(models, layers, transport=transport, seed=seed)
    rng = random.Random(seed)
    for model in simulation.world.models.values():
        model.base.physics_body.velocity = (rng.uniform(-3, 3), rng.uniform(-3, 3), 0.0)
    return Witnessed(simulation.world)


WITNESS = "type: Witness, name: witness"
TIMED = "type: Timed, name: timed, rate: 7"
ANNOUNCER = "type: Announcer, name: announcer, rate: 30"


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    "plugins",
    [(), (WITNESS,), (TIMED, ANNOUNCER), (WITNESS, TIMED, ANNOUNCER)],
    ids=["none", "contacts", "timers", "all"],
)
def test_steps_at_once_equal_single_steps(files, plugins, seed):
    single, many = (make_run(files, *plugins, seed=seed) for _ in range(2))
    rng = random.Random(seed)
    steps = 0
    for _ in range(40):
        count = rng.choice([1, 2, 30, 150])
        steps += count
        topics = rng.choice([(), ("/news",)])
        for each, at_once in ((single, False), (many, True)):
            if count == 2:
                each.world.transport.set_subscribed_topics(topics)
            each.make(count, at_once)
        assert many.seen() == single.seen()
        assert many.save_state() == single.save_state()

    assert many.calls < 0.7 * steps


def test_without_plugins_there_are_few_calls(files):
    assert make_run(files).make(1000, at_once=True).calls == 10


def test_a_plugin_without_work_does_not_split_steps_at_once(files):
    run = make_run(files, ANNOUNCER).make(1, at_once=True)
    run.make(100, at_once=True)
    assert run.calls == 2

    run.world.transport.set_subscribed_topics(("/news",))
    run.make(100, at_once=True)

    # At 30 Hz from the first step on: the first steps after 533.3, 566.7, 600 ms ...
    steps = [time // 5_000_000 for time, *_ in run.log]
    assert steps == [math.ceil(i * 200 / 30) for i in range(31) if i * 200 / 30 > 100]


def test_a_transport_with_unknown_subscribers_gets_single_steps(files):
    class Unsure(LocalTransport):
        subscriber_revision = Transport.subscriber_revision

    assert make_run(files, ANNOUNCER, transport=Unsure()).make(50, at_once=True).calls == 50


def test_after_step_callbacks_split_steps_made_at_once(files):
    run = make_run(files)
    flushes: List[int] = []
    run.transport.flush = lambda: flushes.append(run.timekeeper.nanoseconds)

    run.step(50)
    assert flushes == [250_000_000]

    run.after_step.append(lambda: None)
    run.step(3)
    assert flushes[1:] == [255_000_000, 260_000_000, 265_000_000]

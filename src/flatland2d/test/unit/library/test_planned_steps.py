"""Steps in which no plugin is due go straight to the core, with the same results."""

import random
from typing import Any, List

import pytest
from library.parts import BODY

from flatland2d import Simulation, UsageError, messages
from flatland_server import ModelPlugin, PluginDeclaration, PluginLoader, UpdateTimer

Float = messages.get("std_msgs/Float64")


class Clocked(ModelPlugin):
    """Notes its messages and the times of its updates, at a rate that can be commanded."""

    rate = 7.0

    def on_initialize(self, config):
        self.update_timer = UpdateTimer(self.rate)
        config.finish()
        self.notes: List[Any] = []
        self.node.subscribe("/cue", Float, self.hear)
        self.publisher = self.node.advertise("/cue", Float)

    def hear(self, message):
        self.notes.append(("heard", message.data))
        if message.data > 0.5:
            self.publisher.publish(Float(message.data - 0.3))

    def command(self, rate):
        self.update_timer = UpdateTimer(rate)
        self.publisher.publish(Float(0.6))

    def before_physics_step(self, timekeeper):
        self.notes.append(timekeeper.nanoseconds)
        self.model.base.physics_body.velocity = (0.1, 0.0, len(self.notes) % 5 - 2.0)

    def get_state(self):
        return self.notes

    def set_state(self, state):
        self.notes = state


class Announcer(Clocked):
    """Works for subscribers alone."""

    rate = 30.0

    def on_initialize(self, config):
        super().on_initialize(config)
        self.news = self.node.advertise("/news", Float)

    def has_work(self):
        return self.news.has_subscribers

    def before_physics_step(self, timekeeper):
        self.notes.append(timekeeper.nanoseconds)
        self.news.publish(Float(timekeeper.seconds))


class Toucher(ModelPlugin):
    """Is moved back when it touches something."""

    def on_initialize(self, config):
        config.finish()
        self.notes: List[Any] = []

    def begin_contact(self, contact):
        self.notes.append((self.sim.time, self.model.base.pose))
        self.sim.move(self.model.name, [0.1 * len(self.notes), -1, 0])

    def get_state(self):
        return self.notes


LOADER = PluginLoader([PluginDeclaration.of(each) for each in (Clocked, Announcer, Toucher)])


def model(*plugins: str) -> Any:
    own = [{"type": each, "name": each.lower()} for each in plugins]
    return {"bodies": [BODY], "plugins": own}


@pytest.fixture
def make():
    """Makes equal simulations."""
    models = [
        {"name": "robot", "model": model("Clocked", "Announcer")},
        {"name": "box", "model": model(), "pose": [0.3, 0.9, 0]},
    ]
    return lambda: Simulation({"properties": {}, "layers": [], "models": models}, loader=LOADER)


class Actions:
    """Random actions of a program between steps, equal for equal seeds."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.spawned: List[str] = []

    def act(self, sim: Simulation) -> None:
        rng = self.rng
        kind = rng.choice(["publish", "send", "rate", "spawn", "delete", "subscribe", "subscribe"])
        if kind == "publish":
            sim.publish("/cue", Float(rng.random()))
        elif kind == "send":
            sim.transport.send("/cue", Float(1.0))
        elif kind == "rate":
            sim.models["robot"].drives["clocked"].command(rng.choice([3.0, 40.0]))
        elif kind == "spawn":
            name, plugin = f"late{len(self.spawned)}", rng.choice(["Clocked", "Toucher"])
            self.spawned.append(name)
            sim.spawn(model(plugin), name, [rng.uniform(-1, 1), rng.uniform(-1, 1), 0])
            sim.world.plugins_of(name)[plugin.lower()].sim = sim
        elif kind == "delete" and self.spawned:
            sim.delete(self.spawned.pop())
        elif kind == "subscribe":
            sim.transport.set_subscribed_topics(rng.choice([(), ("/news",)]))
        if rng.random() < 0.3:
            sim.transport.process()
            sim._step_with_hooks()


@pytest.mark.parametrize("seed", range(4))
def test_planned_steps_equal_steps_with_hooks_asked_each_time(make, seed):
    planned, asked = make(), make()
    ours, theirs = Actions(seed), Actions(seed)
    rng = random.Random(seed)
    for _ in range(60):
        count = rng.choice([1, 1, 1, 2, 30, 150])
        for _ in range(5):
            planned.step(count)
            for _ in range(count):
                asked.transport.process()
                asked._step_with_hooks()
        ours.act(planned)
        theirs.act(asked)
        assert planned.time == asked.time
        assert (planned.poses == asked.poses).all()
        if rng.random() < 0.3:
            assert planned.save_state() == asked.save_state()


def test_plugins_are_asked_when_one_is_due_or_an_input_has_come(make):
    sim = make()
    asked: List[int] = []
    step_up_to = sim._step_up_to
    sim._step_up_to = lambda limit: asked.append(1) or step_up_to(limit)

    for _ in range(200):  # a second, at 7 Hz
        sim.step()
    assert len(asked) < 20

    sim.delete("robot")
    sim.step()
    asked.clear()
    sim.step().step(20)
    assert asked == []
    sim.transport.send("/cue", Float(0.0))
    sim.step()
    assert asked == [1]


def test_each_planned_step_is_recorded(make, tmp_path):
    rosbags = pytest.importorskip("rosbags.highlevel")
    sim = make()
    sim.delete("robot")
    sim.step(2)
    with sim.record(tmp_path / "run.bag", topics=["/clock"]):
        sim.step(3).step().step()
    with rosbags.AnyReader([tmp_path / "run.bag"]) as reader:
        assert [time for _, time, _ in reader.messages()] == list(
            range(10**7, 36 * 10**6, 5 * 10**6)
        )
    sim.close()
    with pytest.raises(UsageError, match="the simulation is closed"):
        sim.step()

"""Plugins are called in their order when they are due and have work."""

from typing import Any, Callable, List, Optional

import pytest

from flatland_server.geometry import Pose
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.update_timer import UpdateTimer

BODY = "bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]\n"

calls: List[Any] = []


class Periodic(ModelPlugin):
    """Records the steps at which it is called; with an update rate or without."""

    def on_initialize(self, config):
        rate = config.get_float("rate", 0.0)
        if rate > 0:
            self.update_timer = UpdateTimer(rate)

    def before_physics_step(self, timekeeper):
        calls.append((timekeeper.nanoseconds // 5_000_000, self.name))


class Speaker(Periodic):
    """Has work only if its topic has a subscriber."""

    def on_initialize(self, config):
        super().on_initialize(config)
        self.publisher = self.node.advertise("speech", str)

    def has_work(self):
        return self.publisher.has_subscribers


class ChangingRate(Periodic):
    """Changes its update rate at its third call."""

    def before_physics_step(self, timekeeper):
        super().before_physics_step(timekeeper)
        if len(calls) == 3:
            self.update_timer = UpdateTimer(100.0)


class Preparing(Periodic):
    def prepare_step(self, timekeeper):
        calls.append((timekeeper.nanoseconds // 5_000_000, f"{self.name} prepares"))


class Asked(Periodic):
    """Counts how often it is asked for work, and acts when it is asked next."""

    asked = 0
    on_ask: Optional[Callable[[], None]] = None

    def has_work(self):
        self.asked += 1
        action, self.on_ask = self.on_ask, None
        if action is not None:
            action()
        return True


@pytest.fixture
def load(files):
    """Loads a model with plugins, given as "type name, key: value"."""
    calls.clear()
    classes = (Periodic, Speaker, Preparing, ChangingRate, Asked)
    loader = PluginLoader(map(PluginDeclaration.of, classes))

    def load(*plugins: str, subscribed_topics=None):
        lines = "".join(f"\n  - {{{plugin}}}" for plugin in plugins)
        files.write("robot.yaml", f"{BODY}plugins:{lines}\n")
        transport = LocalTransport(subscribed_topics=subscribed_topics)
        world = files.load(
            "properties: {}\nlayers: []\nmodels: [{name: robot, model: robot.yaml}]",
            transport=transport,
            loader=loader,
        )
        return SimulationManager(world, Timekeeper(0.005)), transport

    return load


def plugins_of(manager) -> Any:
    """The plugins of the model, by name."""
    return manager.world.plugins_of("robot")


def spawn(manager, name: str) -> None:
    """Adds another model of the same file."""
    manager.world.spawn_model("robot.yaml", name, "", Pose())


def run(manager, steps: int) -> List[Any]:
    for _ in range(steps):
        manager.step()
    return calls


def test_plugins_of_different_rates_are_called_in_their_order(load):
    manager, _ = load(
        "type: Periodic, name: slow, rate: 50",
        "type: Periodic, name: always",
        "type: Periodic, name: quick, rate: 100",
    )

    assert run(manager, 5) == [
        *[(0, "slow"), (0, "always"), (0, "quick")],
        (1, "always"),
        *[(2, "always"), (2, "quick")],
        (3, "always"),
        *[(4, "slow"), (4, "always"), (4, "quick")],
    ]


def test_plugins_without_work_are_not_called(load):
    manager, transport = load(
        "type: Speaker, name: always", "type: Speaker, name: slow, rate: 50", subscribed_topics=()
    )

    assert run(manager, 3) == []

    transport.set_subscribed_topics({"/speech"})
    assert run(manager, 2) == [(3, "always"), *[(4, "always"), (4, "slow")]]

    transport.set_subscribed_topics(())
    calls.clear()
    assert run(manager, 20) == []


@pytest.mark.parametrize("is_set_again", [False, True])
def test_the_update_timer_goes_on_while_there_is_no_work(load, is_set_again):
    manager, transport = load("type: Speaker, name: slow, rate: 50", subscribed_topics=())

    run(manager, 7)
    transport.set_subscribed_topics({"/speech"})
    speaker = plugins_of(manager)["slow"]
    if is_set_again:
        speaker.update_timer = speaker.update_timer

    assert run(manager, 6) == [(8, "slow"), (12, "slow")]


@pytest.mark.parametrize("rate", ["", ", rate: 50"])
def test_a_plugin_is_asked_again_only_when_something_has_changed(load, rate):
    manager, transport = load(f"type: Asked, name: asked{rate}", subscribed_topics=())
    asked = plugins_of(manager)["asked"]
    run(manager, 50)
    assert asked.asked == 1

    transport.set_subscribed_topics({"/speech"})
    run(manager, 50)
    assert asked.asked == 2

    spawn(manager, "other")
    run(manager, 50)
    assert asked.asked == 3

    manager.world.delete_model("other")
    run(manager, 50)
    assert asked.asked == 4


@pytest.mark.parametrize("rate", ["", ", rate: 100"])
def test_a_plugin_stopped_during_has_work_calls_is_not_called(load, rate):
    manager, _ = load(f"type: Asked, name: asked{rate}", f"type: Periodic, name: other{rate}")
    world = manager.world
    spawn(manager, "late")
    late = world.plugins_of("late")["asked"]
    plugins_of(manager)["asked"].on_ask = lambda: world.delete_model("late")

    assert run(manager, 1) == [(0, "asked"), (0, "other")]
    assert late.asked == 0


def test_all_plugins_are_asked_again_after_an_interrupt(load):
    def interrupt() -> None:
        raise KeyboardInterrupt

    manager, _ = load("type: Periodic, name: other", "type: Asked, name: asked")
    asked = plugins_of(manager)["asked"]
    asked.on_ask = interrupt

    with pytest.raises(KeyboardInterrupt):
        manager.step()

    assert run(manager, 1) == [(0, "other"), (0, "asked")]


def test_a_plugin_that_has_asked_its_timer_itself_is_due_later(load):
    manager, _ = load("type: Periodic, name: slow, rate: 50")
    run(manager, 4)

    assert plugins_of(manager)["slow"].update_timer.check_update(manager.timekeeper)

    assert run(manager, 5) == [(0, "slow"), (8, "slow")]


def test_a_plugin_may_change_its_update_rate(load):
    manager, _ = load("type: ChangingRate, name: changing")

    assert [step for step, _ in run(manager, 9)] == [0, 1, 2, 3, 5, 7]


def test_a_plugin_that_sets_its_rate_in_has_work_is_called_once(load):
    manager, _ = load("type: Asked, name: asked")
    asked = plugins_of(manager)["asked"]
    asked.on_ask = lambda: setattr(asked, "update_timer", UpdateTimer(100.0))

    assert [step for step, _ in run(manager, 5)] == [0, 2, 4]


@pytest.mark.parametrize("rate", ["", ", rate: 50"])
def test_a_plugin_that_fails_in_has_work_is_switched_off(load, rate):
    manager, _ = load(f"type: Asked, name: failing{rate}", "type: Periodic, name: other")
    plugins_of(manager)["failing"].on_ask = lambda: 1 / 0

    assert run(manager, 2) == [(0, "other"), (1, "other")]
    assert [failure.name for failure in manager.world.plugin_failures] == ["failing"]


def test_the_plugins_of_a_deleted_model_are_not_called_any_more(load):
    manager, _ = load("type: Periodic, name: slow, rate: 50", "type: Periodic, name: always")
    run(manager, 1)
    manager.world.delete_model("robot")
    calls.clear()

    assert run(manager, 10) == []


def test_all_due_plugins_prepare_before_any_is_called(load):
    manager, _ = load(
        "type: Preparing, name: slow, rate: 100",
        "type: Periodic, name: other",
        "type: Preparing, name: always",
    )

    assert run(manager, 2) == [
        *[(0, "slow prepares"), (0, "always prepares")],
        *[(0, "slow"), (0, "other"), (0, "always")],
        *[(1, "always prepares"), (1, "other"), (1, "always")],
    ]

"""Resets, and other contents in place of the former: all or nothing, with topics kept open."""

import gc
import weakref

import pytest
from world.parts import EMPTY, Herald, Talker, spawn, state

from flatland_server import _core
from flatland_server.exceptions import FlatlandError, YamlError
from flatland_server.geometry import Pose

WORLD = """
properties: {}
layers: [{name: map, map: MAP}]
models:
  - {name: a, model: good.yaml}
  - {name: b, model: plain.yaml, pose: [2, 0, 0]}
plugins: [{type: Herald, name: herald}]
"""


@pytest.fixture
def load(models, transport, simulate):
    """Loads the world of two models."""

    def load(text: str = WORLD):
        text = text.replace("MAP", models.walls("map", "-5 -5 5 -5"))
        return simulate(models.load(text, transport=transport))

    return load


def test_a_reset_restores_models_walls_and_poses_of_the_files(models, load):
    simulation = load()
    world = simulation.world
    before = state(world), [model.pose for model in world.models.values()]
    world.delete_model("a")
    spawn(models, world, "good.yaml", "c")
    world.move_model("b", Pose(1.0, 1.0, 1.0))
    world.add_walls("map", [[0.0, 1.0, 2.0, 1.0]])
    simulation.run(0.1)

    simulation.reset()

    assert (state(world), [model.pose for model in world.models.values()]) == before
    assert len(world.layers[0].segments) == 1
    assert simulation.timekeeper.nanoseconds == 0
    assert simulation.last("/chatter") is None
    assert simulation.transport.transforms == {}
    simulation.run()
    assert simulation.last("/chatter") == "a at 5000000"


def test_former_objects_are_gone_after_a_reset(load):
    simulation = load()
    former = simulation.world.models["a"]
    body = former.base.physics_body

    simulation.reset()

    assert simulation.world.models["a"] is not former
    assert not body.alive
    with pytest.raises(_core.GoneError):
        _ = body.pose
    with pytest.raises(FlatlandError, match='the model "a" has been deleted'):
        _ = former.pose


def test_topics_stay_open_while_the_world_is_reset(load, transport, monkeypatch):
    simulation = load()
    open_topics = []
    monkeypatch.setattr(
        Talker, "on_shutdown", lambda _: open_topics.append("/chatter" in transport.topics)
    )
    simulation.reset()

    assert open_topics == [True]
    assert "/chatter" in transport.topics


def test_messages_that_wait_are_not_for_the_new_world(load, transport, monkeypatch):
    received = []
    monkeypatch.setattr(
        Talker,
        "on_initialize",
        lambda self, config: (
            self.node.subscribe("command", str, received.append)
            and setattr(self, "_publisher", self.node.advertise("chatter", str))
        ),
    )
    simulation = load()
    simulation.send("/command", "old")

    simulation.reset()
    simulation.send("/command", "new").run()

    assert received == ["new"]


def test_a_world_stays_as_it_is_if_a_plugin_does_not_start_again(load, monkeypatch):
    simulation = load().run(0.1)
    world = simulation.world
    before, models = state(world), dict(world.models)

    def fail(self, config):
        raise config.error("no luck")

    with monkeypatch.context() as patch:
        patch.setattr(Herald, "on_initialize", fail)
        with pytest.raises(YamlError, match="no luck"):
            world.reset()

    assert state(world) == before
    assert dict(world.models) == models
    simulation.run()
    assert simulation.last("/chatter") == "a at 105000000"
    assert simulation.last("/population") == 2
    assert world.plugin_failures == []


def test_a_hook_may_reset_the_world_at_the_end_of_the_step(load, monkeypatch, caplog):
    def reset_once(self, timekeeper):
        self._publisher.publish(len(self.world.models))
        if timekeeper.nanoseconds == 50_000_000:
            self.world.delete_model("a")
            self.world.reset()
            self.world.delete_model("b")

    monkeypatch.setattr(Herald, "after_physics_step", reset_once)
    simulation = load()

    simulation.run(0.1)

    assert list(simulation.world.models) == ["a", "b"]
    assert simulation.world.plugin_failures == []
    assert simulation.timekeeper.nanoseconds == 100_000_000
    assert 'the model "b" is not deleted: the world has been reset before' in caplog.text


@pytest.mark.parametrize(("plugin", "hook"), [(Herald, "on_initialize"), (Talker, "on_shutdown")])
def test_a_reset_is_refused_while_plugins_start_or_stop(load, monkeypatch, plugin, hook):
    refusals = []
    original = getattr(plugin, hook)

    def reset(self, *arguments):
        original(self, *arguments)
        world = self.world if plugin is Herald else simulation.world
        with pytest.raises(FlatlandError) as caught:
            world.reset()
        refusals.append(str(caught.value))

    monkeypatch.setattr(plugin, hook, reset)
    simulation = load()
    simulation.reset().world.delete_model("a")
    assert list(simulation.world.models) == ["b"]
    simulation.reset().close()

    assert refusals == ["the world cannot be reset while plugins are started or stopped"] * 3


def test_an_edited_file_is_loaded_in_place_of_the_former_one(models, load, transport):
    simulation = load().run(0.1)
    world = simulation.world
    other = EMPTY.replace("[]", "[{name: other}]")
    models.write("world.yaml", f"{other}models: [{{name: c, model: plain.yaml}}]\n")

    simulation.reload(world.read_config())

    assert list(world.models) == ["c"]
    assert [layer.name for layer in world.layers] == ["other"]
    assert world.registry.names == ["other"]
    assert transport.topics == set()
    simulation.run()


def test_a_reload_of_a_wrong_file_is_refused_with_its_line(models, load):
    simulation = load().run(0.1)
    world = simulation.world
    before = state(world)

    models.write("world.yaml", f"{EMPTY}models:\n  - {{name: a, model: plain.yaml, poes: 1}}\n")
    with pytest.raises(YamlError, match=r"world\.yaml:4: .*poes"):
        simulation.reload(world.read_config())
    models.write("world.yaml", f"{EMPTY}models:\n  - {{name: a, model: bad.yaml}}\n")
    config = world.read_config()
    with pytest.raises(YamlError, match=r"bad\.yaml:\d+: .*no luck"):
        simulation.reload(config)

    assert state(world) == before
    simulation.run()
    assert simulation.last("/chatter") == "a at 105000000"


def test_no_file_is_read_for_a_reset(models, load):
    simulation = load()
    for file in models.folder.iterdir():
        file.unlink()

    simulation.reset().run()

    assert list(simulation.world.models) == ["a", "b"]


def test_resets_states_and_reloads_are_for_between_steps(load, monkeypatch):
    refusals = []

    def act(self, timekeeper):
        for action, *arguments in (
            (simulation.reset,),
            (simulation.save_state,),
            (simulation.load_state, b""),
            (simulation.reload, self.world.read_config()),
        ):
            with pytest.raises(FlatlandError) as caught:
                action(*arguments)
            refusals.append(str(caught.value))

    monkeypatch.setattr(Herald, "after_physics_step", act)
    simulation = load()
    simulation.run()

    assert refusals == [
        f"{name} is for between steps, not for hooks or for other threads"
        for name in ("reset", "save_state", "load_state", "reload")
    ]
    assert simulation.timekeeper.nanoseconds == 5_000_000


def test_the_former_contents_are_freed_at_once(load):
    simulation = load().run(0.1)
    world = simulation.world
    former = [weakref.ref(each) for each in (*world.models.values(), *world.layers)]
    gc.collect()
    gc.disable()
    try:
        simulation.reset()
        assert [each() for each in former] == [None] * 3
    finally:
        gc.enable()


@pytest.fixture
def collide(models, simulate):
    """Loads a room of discs, and lets them bounce about; returns where they have been."""
    walls = "\n".join(f"{-4 + i % 9} {i // 9} {-3.5 + i % 9} {i // 9 + 0.2}" for i in range(40))
    disc = "{type: circle, radius: 0.3, density: 1}"
    models.write("disc.yaml", f"bodies: [{{name: base, footprints: [{disc}]}}]")
    text = (
        f"properties: {{}}\nlayers: [{{name: map, map: {models.walls('map', walls)}}}]\nmodels:\n"
    )
    text += "".join(
        f"  - {{name: disc{i}, model: disc.yaml, pose: [{i - 3.7}, {0.3 * i}, 0]}}\n"
        for i in range(7)
    )

    def run(simulation=None):
        simulation = simulation or simulate(models.load(text))
        poses, touches = [], 0
        for i, model in enumerate(simulation.world.models.values()):
            model.base.physics_body.velocity = (3.0 - i, 2.0, 1.0)
        for _ in range(100):
            simulation.run()
            poses.append([tuple(each.pose) for each in simulation.world.models.values()])
            touches += len(simulation.world.physics.touches)
        assert touches > 0
        return simulation, poses

    return run


def test_runs_after_resets_equal_those_of_a_new_world(collide):
    _, of_a_new_world = collide()
    simulation, _ = collide()
    for index in range(5):
        world = simulation.world
        if index == 1:
            world.add_walls("map", [[-4.0, 5.0, 4.0, 5.5]])
        if index == 2:
            wall = world.layers[0].physics_bodies[0].fixture(3)
            wall.friction = wall.restitution = 1.0
        if index == 3:
            simulation.load_state(simulation.save_state())
        simulation.reset()
        assert collide(simulation)[1] == of_a_new_world, index


def test_a_reset_leaves_no_former_world(load):
    simulation = load().reset()
    held = []
    for _ in range(4):
        simulation.reset()
        held.append(weakref.ref(simulation.world.physics))
    gc.collect()

    assert [each() is not None for each in held] == [False, False, False, True]

"""Saved states: what is in them, what is refused, and plugins with and without hooks."""

import json

import numpy as np
import pytest
from world.parts import EMPTY, spawn

from flatland_server import PluginDeclaration, PluginLoader, plain_data
from flatland_server.exceptions import StateError
from flatland_server.geometry import Pose
from flatland_server.models.model import ModelConfig
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.simulation.world import WorldPlugin
from flatland_server.simulation.world_config import ModelEntry
from flatland_server.update_timer import UpdateTimer


class Counter(ModelPlugin):
    """Counts steps, draws numbers, and fails at a count of 100, which sets its model in motion."""

    def on_initialize(self, config):
        self.count, self.number = 0, 0.0
        self.update_timer = UpdateTimer(40.0)

    def before_physics_step(self, timekeeper):
        self.count += 1
        self.number = self.rng.random()
        if self.count == 100:
            raise ValueError("too many")

    def on_shutdown(self):
        self.model.base.physics_body.velocity = (0.1, 0.0, 0.0)

    def get_state(self):
        return {"count": self.count, "number": self.number}

    def set_state(self, state):
        self.count, self.number = state["count"], state["number"]


class Forgetful(ModelPlugin):
    """Has no hooks for states."""

    def on_initialize(self, config):
        self.count = 0

    def before_physics_step(self, timekeeper):
        self.count += 1


class Nursery(WorldPlugin):
    """Adds a model without a file when it starts."""

    def on_initialize(self, config):
        [entry] = [each for each in self.world.config.models if each.name == "a"]
        model = ModelConfig(config.file, entry.model.bodies, (), ())
        self.child = self.world.add_model(ModelEntry("child", "", Pose(3.0, 0.0, 0.0), model))

    def get_state(self):
        return None


class Heir(WorldPlugin):
    """Fails at once, and then deletes the last model."""

    def on_initialize(self, config):
        pass

    def after_physics_step(self, timekeeper):
        raise ValueError("too early")

    def on_shutdown(self):
        self.world.delete_model(list(self.world.models)[-1])


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    return PluginLoader(map(PluginDeclaration.of, (Counter, Forgetful, Nursery, Heir)))


WORLD = f"""{EMPTY}
models:
  - {{name: a, model: counts.yaml}}
  - {{name: b, model: plain.yaml, pose: [1, 0, 0]}}
plugins: [{{type: Nursery, name: nursery}}]
"""


@pytest.fixture
def load(models, simulate):
    """Loads the world with a counter, a forgetful plugin and a nursery."""
    text = (models.folder / "plain.yaml").read_text()
    plugins = "plugins:\n  - {type: Counter, name: counter}\n  - {type: Forgetful, name: forgets}\n"
    models.write("counts.yaml", text + plugins)
    return lambda: simulate(models.load(WORLD))


def plugins(simulation):
    """The counter and the forgetful plugin."""
    return [plugin for plugin, _ in simulation.world.all_plugins_of("a")]


def test_plugins_get_their_state_timer_and_chance(load):
    first = load().run(0.31)
    state = first.save_state()

    second = load().load_state(state)

    counter, forgetful = plugins(second)
    assert counter.count == plugins(first)[0].count == 13
    assert (plugins(first)[1].count, forgetful.count) == (62, 0)
    assert second.timekeeper.nanoseconds == 310_000_000
    first.run(0.1), second.run(0.1)
    assert counter.count == plugins(first)[0].count == 17
    assert counter.number == plugins(first)[0].number
    assert second.world.plugins_without_state_hooks == ["a/forgets"]


def test_a_plugin_that_has_failed_stays_switched_off(load):
    first = load().run(3.0)
    [failure] = first.world.plugin_failures

    state = first.save_state()

    second = load().load_state(state)

    assert second.world.plugin_failures == [failure]
    assert second.save_state() == state
    second.run(0.5)
    assert plugins(second)[0].count == 0


def test_what_a_failed_plugin_did_at_its_end_is_not_repeated(models, simulate):
    models.write("counts.yaml", (models.folder / "plain.yaml").read_text())
    first, second = (simulate(models.load(WORLD.replace("Nursery", "Heir"))) for _ in range(2))
    state = first.run(0.02).save_state()

    second.load_state(state)

    assert list(second.world.models) == ["a"]
    assert second.save_state() == state


def test_models_and_walls_are_those_of_the_state(models, load):
    first = load()
    spawn(models, first.world, "counts.yaml", "c", pose=Pose(0.0, 2.0, 0.0))
    first.world.delete_model("b")
    first.world.delete_model("child")
    spawn(models, first.world, "plain.yaml", "b", namespace="ns", pose=Pose(5.0, 0.0, 0.0))
    first.world.move_model("c", Pose(0.0, -2.0, 1.0))
    first.run(0.1)
    state = first.save_state()

    second = load()
    spawn(models, second.world, "plain.yaml", "left_over", pose=Pose(9.0, 0.0, 0.0))
    second.load_state(state)

    assert list(second.world.models) == list(first.world.models) == ["a", "c", "b"]
    for name, model in first.world.models.items():
        other = second.world.models[name]
        assert other.pose == model.pose
        assert other.namespace == model.namespace
        assert other.move_revision == model.move_revision
    assert second.save_state() == state


def test_a_saved_state_is_json(load):
    state = load().run(0.1).save_state()

    content = json.loads(state)

    assert content["flatland_state"] == 1
    assert content["plugins"][0]["state"]["count"] == 4
    assert [model["name"] for model in content["models"]] == ["a", "b", "child"]


def damaged(state, change):
    content = plain_data.loads(state)
    change(content)
    return plain_data.dumps(content)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.update(flatland_state=7), "expected a state of format 1, found format 7"),
        (lambda c: c.pop("flatland_state"), "expected the state of a world, found something else"),
        (lambda c: c.pop("seed"), "the state is damaged: .*seed"),
        (lambda c: c.update(seed="x"), r"state\.seed: expected another value, found 'x'"),
        (lambda c: c.update(seed=-1), r"state\.seed: expected another value, found -1"),
        (lambda c: c["models"].pop(), "another world: the number of bodies: expected 4, found 6"),
        (lambda c: c["plugins"].pop(), "expected the plugins a/counter, a/forgets, nursery; found"),
        (lambda c: c["plugins"][0].update(type="X"), '"a/counter" is a X in the state, here a Co'),
        (lambda c: c["plugins"][0].update(state=1), 'plugin "a/counter": set_state: TypeError'),
        (lambda c: c.update(physics=c["physics"][:-1]), "the state is damaged"),
        (lambda c: c["walls"].append({"order": 1, "layer": 0, "segments": 1}), "expected walls as"),
        (lambda c: c.update(own_walls=np.array([[1j] * 4])), "damaged: expected walls as arrays"),
        (lambda c: c.update(nanoseconds=2**62), "damaged: expected a time of 0 to 1e9 s"),
        (lambda c: c["wall_counts"].update(map=3), 'the layer "map" has 3 walls there, no here'),
    ],
)
def test_a_state_that_does_not_fit_is_refused_without_effect(load, change, message):
    simulation = load().run(0.1)
    state = simulation.save_state()
    before = simulation.world.models["a"]

    with pytest.raises(StateError, match=message):
        simulation.load_state(damaged(state, change))

    assert simulation.world.models["a"] is before
    assert simulation.timekeeper.nanoseconds == 100_000_000
    assert simulation.save_state() == state
    simulation.run()


@pytest.mark.parametrize("data", [b"", b"{}", b"[1, 2]", b"\xff\x00", b"not json", b'{"a":' * 9])
def test_bytes_that_are_no_state_are_refused(load, data):
    with pytest.raises(StateError, match="expected the state of a world, found something else"):
        load().load_state(data)


def test_a_state_needs_the_files_of_spawned_models(models, load):
    simulation = load()
    models.write("later.yaml", (models.folder / "plain.yaml").read_text())
    spawn(models, simulation.world, "later.yaml", "c", pose=Pose(0.0, 3.0, 0.0))
    state = simulation.save_state()

    (models.folder / "later.yaml").unlink()
    with pytest.raises(StateError, match=r"there is no file .*later\.yaml"):
        simulation.load_state(state)
    models.write("later.yaml", "bodies: {}\n")
    with pytest.raises(StateError, match=r"later\.yaml:1"):
        simulation.load_state(state)
    assert list(simulation.world.models) == ["a", "b", "child", "c"]


def test_a_model_that_a_program_has_made_cannot_be_saved(load):
    simulation = load()
    world = simulation.world
    config = ModelConfig(world.models["b"].config.path, world.models["b"].config.bodies, (), ())
    world.add_model(ModelEntry("made", "", Pose(0.0, 4.0, 0.0), config))

    with pytest.raises(StateError, match='the model "made" was made by a program, without a file'):
        simulation.save_state()


def test_a_plugin_with_a_state_that_is_no_data_is_named(load, monkeypatch):
    simulation = load().run(0.1)
    monkeypatch.setattr(Counter, "get_state", lambda self: {"me": [self]})

    message = r'"a/counter": get_state: TypeError: data\[\'me\'\]\[0\]: expected numbers, .*Counter'
    with pytest.raises(StateError, match=message):
        simulation.save_state()


@pytest.mark.parametrize(
    "data",
    [
        None,
        [True, 1, -(2**127), 0.1, -0.0, 1e-320, "ä", b"\x00\xff"],
        {"a": {"$bytes": 3}, "$array": [1]},
        {1: {"b": [[]]}, "c": {}},
    ],
)
def test_plain_data_comes_back_as_it_was(data):
    assert repr(plain_data.loads(plain_data.dumps(data))) == repr(data)


def test_numbers_and_arrays_of_numpy_come_back_bit_for_bit():
    arrays = [
        np.arange(6, dtype=np.float32).reshape(2, 3) / 7,
        np.array([True, False]),
        np.array(2.5),
        np.empty((0, 4)),
        np.arange(3, dtype=">i2"),
        np.array([1 + 2j, np.nan, -np.inf]),
    ]
    numbers = plain_data.loads(plain_data.dumps([np.float64(0.1), np.int8(3), np.bool_(True)]))

    assert numbers == [0.1, 3, True]
    for array, back in zip(arrays, plain_data.loads(plain_data.dumps(arrays))):
        np.testing.assert_array_equal(back, array)
        assert back.dtype == array.dtype.newbyteorder("=")
        assert back.flags.writeable


def test_tuples_come_back_as_lists():
    assert plain_data.loads(plain_data.dumps({"a": (1, (2,))})) == {"a": [1, [2]]}


@pytest.mark.parametrize(
    "data", [{1, 2}, object(), [print], np.array([object()]), {"a": {(1,): 1}}]
)
def test_data_that_is_not_plain_is_refused(data):
    with pytest.raises(TypeError, match=r"^data.*: expected (numbers, strings|keys)"):
        plain_data.dumps(data)


def test_an_array_of_objects_is_not_read():
    with pytest.raises(ValueError, match="expected an array of numbers, found one of object"):
        plain_data.loads(b'{"$array": ["|O", [1], "AAAAAAAAAAA="]}')

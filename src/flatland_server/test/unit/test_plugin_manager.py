"""The life of plugins in a world: starting, being called, failing and ending."""

import logging
import math
from typing import Any, Iterator, List, Tuple

import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.model_plugin import ModelPlugin
from flatland_server.plugin import Plugin
from flatland_server.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer
from flatland_server.world_plugin import WorldPlugin

BODY = "bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]\n"

calls: List[Tuple[Any, ...]] = []
"""What was called so far: (plugin, hook, ...)."""


class Recorder(ModelPlugin):
    """Notes its calls, with the time [ns]; may fail in one of its hooks."""

    def on_initialize(self, config):
        self._fails_in = config.get_string("fails_in", "")
        self.update_timer = UpdateTimer(config.get_rate("update_rate", math.inf))
        self._note("on_initialize")

    def before_physics_step(self, timekeeper):
        self._note("before", timekeeper.nanoseconds)

    def after_physics_step(self, timekeeper):
        self._note("after", timekeeper.nanoseconds)

    def on_shutdown(self):
        self._note("on_shutdown")

    def _note(self, hook: str, *more: Any) -> None:
        calls.append((f"{self.model.name}/{self.name}", hook, *more))
        if hook == self._fails_in:
            raise RuntimeError("no luck")


class WorldRecorder(WorldPlugin):
    def on_initialize(self, config):
        calls.append((self.name, "on_initialize", sorted(self.world.models)))

    def before_physics_step(self, timekeeper):
        calls.append((self.name, "before", timekeeper.nanoseconds))

    def after_physics_step(self, timekeeper):
        calls.append((self.name, "after", timekeeper.nanoseconds))


class OnlyAfter(ModelPlugin):
    def on_initialize(self, config):
        pass

    def after_physics_step(self, timekeeper):
        calls.append((self.name, "after"))


class Dice(ModelPlugin):
    """Throws dice when it starts."""

    def on_initialize(self, config):
        calls.append((f"{self.model.name}/{self.name}", tuple(self.rng.integers(1000, size=4))))


class Unfinished(ModelPlugin):
    pass


class Greedy(ModelPlugin):
    """Deletes a model in the midst of a step."""

    def on_initialize(self, config):
        self.world: Any = None

    def before_physics_step(self, timekeeper):
        try:
            self.world.delete_model("robot")
        except FlatlandError as error:
            calls.append(("refused", str(error)))


@pytest.fixture(autouse=True)
def _forget_calls() -> Iterator[None]:
    calls.clear()
    yield
    calls.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of this file."""
    classes = (Recorder, WorldRecorder, OnlyAfter, Dice, Unfinished, Greedy)
    return PluginLoader(
        PluginDeclaration(c.__name__, "test", f"{__name__}.{c.__name__}") for c in classes
    )


def world_of(files, models: str, plugins: str = "[]", **options: Any):
    """A world of models, given as "name: plugin | plugin; name: ..."."""
    entries = ""
    for model in models.split(";"):
        name, _, its_plugins = model.partition(":")
        write_model(files, name.strip(), its_plugins)
        entries += f"\n  - {{name: {name.strip()}, model: {name.strip()}.yaml}}"
    text = f"properties: {{}}\nlayers: []\nplugins: {plugins}\nmodels:{entries}"
    return files.load(text, **options)


def write_model(files, name: str, plugins: str):
    """A model file with these plugins, one a line from line 3 on."""
    lines = "".join(
        f"\n  - {{{plugin.strip()}}}" for plugin in plugins.split("|") if plugin.strip()
    )
    return files.write(f"{name}.yaml", f"{BODY}plugins:{lines or ' []'}\n")


def step(world, count: int = 1) -> None:
    timekeeper = Timekeeper(0.005)
    for _ in range(count):
        world.step(timekeeper)


def errors(caplog: pytest.LogCaptureFixture) -> List[str]:
    """The errors logged so far."""
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.ERROR]


def test_hooks_are_called_in_the_order_of_the_files_the_worlds_last(files):
    models = "b: type: Recorder, name: y | type: Recorder, name: x; a: type: Recorder, name: z"
    world = world_of(files, models, "[{type: WorldRecorder, name: w}]")
    assert calls == [
        ("b/y", "on_initialize"),
        ("b/x", "on_initialize"),
        ("a/z", "on_initialize"),
        ("w", "on_initialize", ["a", "b"]),
    ]
    calls.clear()

    step(world, 2)

    names = ["b/y", "b/x", "a/z", "w"]
    assert calls == [
        *((name, "before", 0) for name in names),
        *((name, "after", 5_000_000) for name in names),
        *((name, "before", 5_000_000) for name in names),
        *((name, "after", 10_000_000) for name in names),
    ]


def test_a_hook_that_is_not_overridden_is_never_called(files, monkeypatch):
    monkeypatch.setattr(Plugin, "before_physics_step", lambda *_: calls.append(("base class",)))
    world = world_of(files, "robot: type: OnlyAfter, name: a")

    step(world)

    assert calls == [("a", "after")]


def test_a_plugin_with_a_rate_is_called_only_when_it_is_due(files):
    world = world_of(files, "robot: type: Recorder, name: slow, update_rate: 10")
    calls.clear()

    step(world, 200)

    befores = [time for _, hook, time in calls if hook == "before"]
    afters = [time for _, hook, time in calls if hook == "after"]
    assert befores == [100_000_000 * i for i in range(10)]
    assert afters == [time + 5_000_000 for time in befores]


@pytest.mark.parametrize("hook", ["before", "after"])
def test_a_plugin_that_fails_is_switched_off_and_the_others_go_on(files, caplog, hook):
    plugins = f"type: Recorder, name: bad, fails_in: {hook} | type: Recorder, name: good"
    world = world_of(files, f"robot: {plugins}")
    calls.clear()

    step(world, 3)

    assert [call for call in calls if call[0] == "robot/bad"][-1][1] == hook
    assert [call[1] for call in calls if call[0] == "robot/bad"].count(hook) == 1
    assert [call[1] for call in calls if call[0] == "robot/good"] == ["before", "after"] * 3
    [message] = errors(caplog)
    assert '"bad"' in message
    assert f"{hook}_physics_step" in message


def test_a_plugin_that_was_switched_off_stays_off_when_models_come_and_go(files):
    world = world_of(files, "robot: type: Recorder, name: bad, fails_in: before")
    other = write_model(files, "other", "type: Recorder, name: good")
    step(world)
    calls.clear()

    world.spawn_model(other, "other", "", Pose())
    step(world)
    world.delete_model("other")
    step(world)

    assert [call for call in calls if call[0] == "robot/bad"] == []


def test_deleting_a_model_ends_its_plugins_the_last_one_first(files):
    plugins = "type: Recorder, name: a | type: Recorder, name: b"
    world = world_of(files, f"robot: {plugins}; other: {plugins}")
    calls.clear()

    world.delete_model("robot")
    step(world)

    assert calls[:2] == [("robot/b", "on_shutdown"), ("robot/a", "on_shutdown")]
    assert {call[0] for call in calls[2:]} == {"other/a", "other/b"}


def test_a_plugin_that_fails_at_its_end_does_not_keep_the_others(files, caplog):
    plugins = "type: Recorder, name: a | type: Recorder, name: b, fails_in: on_shutdown"
    world = world_of(files, f"robot: {plugins}")
    calls.clear()

    world.delete_model("robot")

    assert calls == [("robot/b", "on_shutdown"), ("robot/a", "on_shutdown")]
    assert '"b"' in errors(caplog)[0]


def test_the_end_of_the_world_ends_all_plugins_once(files):
    world = world_of(files, "a: type: Recorder, name: p; b: type: Recorder, name: p")
    calls.clear()

    world.close()
    world.close()

    assert sorted(calls) == [("a/p", "on_shutdown"), ("b/p", "on_shutdown")]


def test_plugins_that_had_started_are_ended_when_one_does_not_start(files):
    world = world_of(files, "robot:")
    plugins = "type: Recorder, name: a | type: Recorder, name: b, fails_in: on_initialize"
    path = write_model(files, "other", plugins)

    with pytest.raises(FlatlandError):
        world.spawn_model(path, "other", "", Pose())

    assert calls == [
        ("other/a", "on_initialize"),
        ("other/b", "on_initialize"),
        ("other/a", "on_shutdown"),
    ]


@pytest.mark.parametrize(
    ("plugin", "message"),
    [
        pytest.param(
            "type: Recordr, name: a",
            'plugins[0].type: unknown plugin type "Recordr" (did you mean "Recorder"?); there are: '
            "Dice, Greedy, OnlyAfter, Recorder, Unfinished, WorldRecorder",
            id="unknown type",
        ),
        pytest.param(
            "type: WorldRecorder, name: a",
            f'plugins[0].type: "WorldRecorder" is not a ModelPlugin: {__name__}.WorldRecorder',
            id="a plugin of the world",
        ),
        pytest.param(
            "type: Recorder, name: a, fails_in: on_initialize",
            'plugins[0] "a": does not start: RuntimeError: no luck',
            id="an exception",
        ),
        pytest.param(
            "type: Recorder, name: a, update_rat: 1",
            'plugins[0] "a": unknown key "update_rat" (did you mean "update_rate"?)',
            id="a key that the plugin did not ask for",
        ),
        pytest.param(
            "type: Unfinished, name: a",
            'plugins[0] "a": does not start: TypeError: Unfinished does not override on_initialize',
            id="no on_initialize",
        ),
    ],
)
def test_a_plugin_that_does_not_start_is_named_with_its_line(files, plugin, message):
    write_model(files, "robot", plugin)

    refusal = files.refusal(
        "properties: {}\nlayers: []\nmodels: [{name: robot, model: robot.yaml}]"
    )

    assert refusal == f"robot.yaml:3: {message}"


def test_chance_depends_on_seed_model_and_plugin_and_on_nothing_else(files):
    two = "type: Dice, name: p | type: Dice, name: q"

    def throws(models: str, seed: int) -> dict:
        calls.clear()
        world_of(files, models, seed=seed)
        return dict(calls)

    one_way = throws(f"a: {two}; b: {two}", 1)
    other_way = throws(f"b: {two}; c: {two}; a: type: Recorder, name: r | {two}", 1)
    other_seed = throws(f"a: {two}; b: {two}", 2)

    assert {name: other_way[name] for name in one_way} == one_way
    assert len({*one_way.values(), *other_seed.values()}) == 8


def test_models_do_not_come_or_go_in_the_midst_of_a_step(files):
    world = world_of(files, "robot: type: Greedy, name: a")
    [plugin] = world._plugins.plugins_of("robot")
    plugin.world = world

    step(world)

    assert calls == [("refused", "models come, go and are moved between steps, not during one")]
    assert list(world.models) == ["robot"]

"""The life of plugins in a world: starting, being called, failing and ending."""

import logging
import math
from typing import Any, Iterator, List, Tuple

import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.local_transport import LocalTransport
from flatland_server.model_plugin import ModelPlugin
from flatland_server.node import Node
from flatland_server.plugin import Plugin
from flatland_server.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer
from flatland_server.world_plugin import WorldPlugin

DISC = "{type: circle, radius: 0.1, density: 1, restitution: 1}"
BODY = f"bodies: [{{name: base, footprints: [{DISC}]}}]\n"

calls: List[Tuple[Any, ...]] = []
"""What was called so far: (plugin, hook, ...)."""


class Recorder(ModelPlugin):
    """Notes its calls, with the time [ns]; may fail in one of its hooks."""

    def on_initialize(self, config):
        self._fails_in = config.get_string("fails_in", "")
        self.update_timer = UpdateTimer(config.get_rate("update_rate", math.inf))
        self.node.advertise(f"{self.model.name}/{self.name}", str)
        self.node.subscribe("command", str, lambda _: self._note("callback"))
        self.node.claim_frame("map", f"{self.model.name}/{self.name}")
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


class Toucher(Recorder):
    """Notes its contacts too."""

    def begin_contact(self, contact):
        self._note("begin_contact")

    def pre_solve(self, contact, old_manifold):
        self._note("pre_solve")

    def end_contact(self, contact):
        self._note("end_contact")

    def post_solve(self, contact, impulse):
        self._note("post_solve")


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
    """Throws dice when it starts."""

    def on_initialize(self, config):
        calls.append((f"{self.model.name}/{self.name}", tuple(self.rng.integers(1000, size=4))))


class Unfinished(ModelPlugin):
    pass


@pytest.fixture(autouse=True)
def _forget_calls() -> Iterator[None]:
    calls.clear()
    yield
    calls.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of this file."""
    classes = (Recorder, Toucher, WorldRecorder, OnlyAfter, Dice, Unfinished)
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


def hooks_of(plugin: str) -> List[str]:
    """The hooks of a plugin that were called so far."""
    return [hook for name, hook, *_ in calls if name == plugin]


def local(world) -> LocalTransport:
    assert isinstance(world.transport, LocalTransport)
    return world.transport


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


BOUNCE = {"begin_contact", "pre_solve", "post_solve", "end_contact"}
FAILURES = {"before": "before_physics_step", "after": "after_physics_step"}
FAILURES.update({hook: hook for hook in BOUNCE}, callback="its callback of command")
"""Where a plugin may fail, and what the log calls it."""


def run_a_collision(world) -> None:
    """Lets the models "robot" and "other", each a disc, bounce off each other; a command comes."""
    local(world).send("/command", "go")
    local(world).process()
    world.move_model("robot", Pose(0.0, 0.0, 0.0))
    world.move_model("other", Pose(0.22, 0.0, 0.0))
    for name, speed in (("robot", 2.0), ("other", -2.0)):
        world.get_model(name).base.physics_body.velocity = (speed, 0.0, 0.0)
    step(world, 10)


@pytest.mark.parametrize("hook", sorted(FAILURES))
def test_a_plugin_that_fails_is_switched_off_and_the_others_go_on(files, caplog, hook):
    plugins = f"type: Toucher, name: bad, fails_in: {hook} | type: Toucher, name: good"
    world = world_of(files, f"robot: {plugins}; other: type: Toucher, name: good")

    run_a_collision(world)
    run_a_collision(world)

    assert hooks_of("robot/bad")[-2:] == [hook, "on_shutdown"]
    assert hooks_of("robot/bad").count(hook) == 1
    for good in ("robot/good", "other/good"):
        assert set(hooks_of(good)) == {"on_initialize", *FAILURES}
        assert hooks_of(good).count("after") == 20
        assert hooks_of(good).count("begin_contact") == hooks_of(good).count("end_contact") == 2
    [record] = [record for record in caplog.records if record.levelno >= logging.ERROR]
    where = FAILURES[hook]
    assert record.getMessage() == f'the plugin "robot/bad" failed in {where} and is switched off'
    assert record.exc_info[0] is RuntimeError
    assert "_note" in caplog.text  # the traceback leads to the line
    [failure] = world.plugin_failures
    reason = f"{where}: RuntimeError: no luck"
    assert failure == ("robot", "bad", "Toucher", reason)


@pytest.mark.parametrize("hook", sorted(FAILURES))
def test_the_topics_and_frames_of_a_plugin_that_fails_go_with_it(files, caplog, hook):
    world = world_of(
        files, f"robot: type: Toucher, name: bad, fails_in: {hook}; other: type: Recorder, name: p"
    )
    assert local(world).topics == {"/robot/bad", "/other/p"}

    run_a_collision(world)
    run_a_collision(world)

    assert local(world).topics == {"/other/p"}
    assert len(local(world)._callbacks["/command"]) == 1
    caplog.clear()
    Node(world.transport, "", "heir", world._plugins._node._frames).claim_frame("odom", "robot/bad")
    assert caplog.records == []


def test_a_hook_is_named_as_such_whatever_its_function_is_called(files, monkeypatch):
    class Fuse:
        def __call__(self, *_):
            raise RuntimeError("no luck")

    monkeypatch.setattr(Recorder, "before_physics_step", Fuse())
    monkeypatch.setattr(Toucher, "begin_contact", Fuse())
    monkeypatch.setattr(Toucher, "before_physics_step", Plugin.before_physics_step)
    world = world_of(files, "robot: type: Recorder, name: p; other: type: Toucher, name: q")

    run_a_collision(world)

    failures = {failure.label: failure.reason for failure in world.plugin_failures}
    assert failures == {
        "robot/p": "before_physics_step: RuntimeError: no luck",
        "other/q": "begin_contact: RuntimeError: no luck",
    }


def test_plugins_that_fail_in_one_step_are_named_each(files, caplog):
    bad = "type: Recorder, name: {}, fails_in: {}"
    plugins = " | ".join(bad.format(*each) for each in (("a", "before"), ("b", "after")))
    world = world_of(
        files,
        f"robot: {plugins}; other: {plugins}",
        "[{type: WorldRecorder, name: w, fails: true}]",
    )

    step(world)

    labels = ["robot/a", "other/a", "w", "robot/b", "other/b"]
    assert [failure.label for failure in world.plugin_failures] == labels
    assert len(errors(caplog)) == 5
    assert world.plugin_failures[2].owner == ""


def test_a_failure_is_forgotten_when_its_model_is_deleted(files):
    bad = "type: Recorder, name: bad, fails_in: before"
    world = world_of(files, f"robot: {bad}; other: {bad}")
    step(world)
    assert len(world.plugin_failures) == 2

    world.delete_model("robot")

    assert [failure.owner for failure in world.plugin_failures] == ["other"]
    assert hooks_of("robot/bad").count("on_shutdown") == 1
    write_model(files, "robot", "type: Recorder, name: bad")
    world.spawn_model(files.folder / "robot.yaml", "robot", "", Pose())
    calls.clear()
    step(world, 2)
    assert hooks_of("robot/bad") == ["before", "after"] * 2


def test_a_plugin_that_fails_twice_over_is_ended_once(files, caplog):
    class Doubly(Recorder):
        def on_shutdown(self):
            super().on_shutdown()
            raise RuntimeError("no luck either")

    loader = PluginLoader([PluginDeclaration("Doubly", "test", "doubly.Doubly")])
    loader.load = lambda *_: Doubly  # type: ignore[method-assign]
    world = world_of(files, "robot: type: Doubly, name: bad, fails_in: before", loader=loader)

    step(world, 2)
    world.delete_model("robot")

    assert hooks_of("robot/bad") == ["on_initialize", "before", "on_shutdown"]
    assert errors(caplog) == [
        'the plugin "robot/bad" failed in before_physics_step and is switched off',
        'the plugin "robot/bad" failed in on_shutdown',
    ]


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
    assert errors(caplog) == ['the plugin "robot/b" failed in on_shutdown']


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


def test_a_spawn_whose_third_plugin_fails_leaves_nothing_behind(files, caplog):
    world = world_of(files, "other: type: Recorder, name: p")
    entities, joints = list(world.entities), world.physics.joint_count
    events: List[Any] = []
    plugins = "type: Toucher, name: a | type: Toucher, name: b | type: Toucher, name: c"
    bad = write_model(files, "bad", f"{plugins}, fails_in: on_initialize")

    with pytest.raises(FlatlandError, match="no luck"):
        world.spawn_model(bad, "robot", "", Pose())
    world.physics.set_contact_listener(lambda *event: events.append(event))
    calls.clear()
    step(world, 2)

    assert {name for name, *_ in calls} == {"other/p"}
    assert list(world.models) == ["other"]
    assert (world.physics.body_count, world.physics.joint_count) == (1, joints)
    assert list(world.entities) == entities
    assert local(world).topics == {"/other/p"}
    assert len(local(world)._callbacks["/command"]) == 1
    assert world._plugins._node._frames._owners == {"other/p": "other/p"}
    assert all(listeners == {} for listeners in world._plugins._contacts._listeners.values())
    assert world._plugins.plugins_of("robot") == []
    # Where it would have been, a disc touches another without anybody being told of it.
    plain = write_model(files, "plain", "")
    for name in ("robot", "second"):
        world.spawn_model(plain, name, "", Pose())
    step(world, 2)
    assert events == []


@pytest.mark.parametrize(
    ("plugin", "message"),
    [
        pytest.param(
            "type: Recordr, name: a",
            'plugins[0].type: unknown plugin type "Recordr" (did you mean "Recorder"?); there are: '
            "Dice, OnlyAfter, Recorder, Toucher, Unfinished, WorldRecorder",
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

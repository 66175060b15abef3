"""A plugin that fails is switched off, its topics are closed, and the others go on."""

import logging
from typing import Any

import pytest
from logged import errors
from plugin_manager.recorders import (
    Recorder,
    Toucher,
    calls,
    hooks_of,
    local,
    step,
    world_of,
    write_model,
)

from flatland_server.exceptions import YamlError
from flatland_server.geometry import Pose
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.run import Run
from flatland_server.timekeeper import Timekeeper

BOUNCE = {"begin_contact", "pre_solve", "post_solve", "end_contact"}
FAILURES = {"before": "before_physics_step", "after": "after_physics_step"}
FAILURES.update({hook: hook for hook in BOUNCE}, callback="its callback of command")
"""Where a plugin may fail, and its name in the log."""


def run_a_collision(world) -> None:
    """Makes the models "robot" and "other", two discs, collide; sends a command before."""
    local(world).send("/command", "go")
    local(world).process()
    world.move_model("robot", Pose(0.0, 0.0, 0.0))
    world.move_model("other", Pose(0.22, 0.0, 0.0))
    for name, speed in (("robot", 2.0), ("other", -2.0)):
        world.get_model(name).base.physics_body.velocity = (speed, 0.0, 0.0)
    step(world, 10)


@pytest.mark.parametrize("exits", [False, True])
@pytest.mark.parametrize("hook", sorted(FAILURES))
def test_a_failing_plugin_is_disabled_and_the_others_go_on(files, caplog, hook, exits):
    """It may also call sys.exit()."""
    bad = f"type: Toucher, name: bad, fails_in: {hook}, exits: {exits}"
    good = "type: Toucher, name: good"
    world = world_of(files, f"robot: {bad} | {good}; other: {good}")

    run_a_collision(world)
    run_a_collision(world)

    assert hooks_of("robot/bad")[-2:] == [hook, "on_shutdown"]
    assert hooks_of("robot/bad").count(hook) == 1
    for good in ("robot/good", "other/good"):
        assert set(hooks_of(good)) == {"on_initialize", *FAILURES}
        assert hooks_of(good).count("after") == 20
        assert hooks_of(good).count("begin_contact") == hooks_of(good).count("end_contact") == 2
    error, where = SystemExit if exits else RuntimeError, FAILURES[hook]
    [record] = [record for record in caplog.records if record.levelno >= logging.ERROR]
    assert record.getMessage() == f'the plugin "robot/bad" failed in {where} and is switched off'
    assert record.exc_info[0] is error
    assert "_record" in caplog.text  # the traceback leads to the line
    [failure] = world.plugin_failures
    assert failure == ("robot", "bad", "Toucher", f"{where}: {error.__name__}: no luck")
    assert local(world).topics == {"/robot/good", "/other/good"}
    assert len(local(world)._callbacks["/command"]) == 2
    caplog.clear()
    world.plugins_of("other")["good"].node.claim_frame("odom", "robot/bad")
    assert caplog.records == []  # no other plugin places this frame


def test_a_failure_names_the_hook_whatever_its_function_is(files, monkeypatch):
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


def test_all_plugins_that_fail_in_one_step_are_reported(files, caplog):
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


def test_a_plugin_that_fails_in_on_shutdown_too_ends_once(files, caplog):
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


def test_a_plugin_that_was_switched_off_stays_off(files):
    world = world_of(files, "robot: type: Recorder, name: bad, fails_in: before")
    other = write_model(files, "other", "type: Recorder, name: good")
    step(world)
    calls.clear()

    world.spawn_model(other, "other", "", Pose())
    step(world)
    world.delete_model("other")
    step(world)

    assert [call for call in calls if call[0] == "robot/bad"] == []


def test_sys_exit_in_on_initialize_refuses_the_model(files):
    world = world_of(files, "other: type: Toucher, name: good")
    bad = "type: Recorder, name: bad, fails_in: on_initialize, exits: true"

    with pytest.raises(YamlError, match="does not start: SystemExit: no luck"):
        world.spawn_model(write_model(files, "bad", bad), "robot", "", Pose())

    assert list(world.models) == ["other"]


class Stepper(ModelPlugin):
    """Tries to step the world in a hook."""

    simulation: Any = None

    def on_initialize(self, config):
        if self.name == "at_start":
            self.simulation.step()

    def before_physics_step(self, timekeeper):
        self.simulation.step()


def test_a_hook_cannot_make_a_step(files, monkeypatch):
    files.loader = PluginLoader([PluginDeclaration.of(Stepper)])
    world = world_of(files, "robot: type: Stepper, name: in_a_step")
    simulation = Run(world, Timekeeper(0.005))
    monkeypatch.setattr(Stepper, "simulation", simulation)

    simulation.step()

    [failure] = world.plugin_failures
    assert failure.reason == (
        "before_physics_step: FlatlandError: a hook of a plugin cannot make a step"
    )
    assert simulation.time == 0.005
    path = write_model(files, "late", "type: Stepper, name: at_start")
    with pytest.raises(YamlError, match="cannot make a step"):
        world.spawn_model(path, "late", "", Pose())
    simulation.step()

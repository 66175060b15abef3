"""Plugins are stopped with their model or world; those that do not start leave nothing behind."""

from typing import Any, List

import pytest
from logged import errors
from plugin_manager.recorders import calls, local, step, world_of, write_model

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose


def test_deleting_a_model_stops_its_plugins_in_reverse_order(files):
    plugins = "type: Recorder, name: a | type: Recorder, name: b"
    world = world_of(files, f"robot: {plugins}; other: {plugins}")
    calls.clear()

    world.delete_model("robot")
    step(world)

    assert calls[:2] == [("robot/b", "on_shutdown"), ("robot/a", "on_shutdown")]
    assert {call[0] for call in calls[2:]} == {"other/a", "other/b"}


def test_a_failing_on_shutdown_does_not_prevent_the_others(files, caplog):
    plugins = "type: Recorder, name: a | type: Recorder, name: b, fails_in: on_shutdown"
    world = world_of(files, f"robot: {plugins}")
    calls.clear()

    world.delete_model("robot")

    assert calls == [("robot/b", "on_shutdown"), ("robot/a", "on_shutdown")]
    assert errors(caplog) == ['the plugin "robot/b" failed in on_shutdown']


def test_a_spawn_that_fails_in_its_third_plugin_leaves_nothing(files, caplog):
    world = world_of(files, "other: type: Recorder, name: p")
    entities, joints = list(world.entities), world.physics.joint_count
    events: List[Any] = []
    plugins = "type: Toucher, name: a | type: Toucher, name: b | type: Toucher, name: c"
    bad = write_model(files, "bad", f"{plugins}, fails_in: on_initialize")

    with pytest.raises(FlatlandError, match="no luck"):
        world.spawn_model(bad, "robot", "", Pose())
    world.physics.set_contact_listener(lambda *event: events.append(event))
    assert calls[-2:] == [("robot/b", "on_shutdown"), ("robot/a", "on_shutdown")]
    calls.clear()
    step(world, 2)

    assert {name for name, *_ in calls} == {"other/p"}
    assert list(world.models) == ["other"]
    assert (world.physics.body_count, world.physics.joint_count) == (1, joints)
    assert list(world.entities) == entities
    assert local(world).topics == {"/other/p"}
    assert len(local(world)._callbacks["/command"]) == 1
    for name in "abc":
        world.plugins_of("other")["p"].node.claim_frame("odom", f"robot/{name}")
    assert caplog.records == []
    assert all(not each for each in world.contents.plugins.contacts._listeners.values())
    assert world.plugins_of("robot") == {}
    # Where it would have been, the core reports no contact of two discs.
    plain = write_model(files, "plain", "")
    for name in ("robot", "second"):
        world.spawn_model(plain, name, "", Pose())
    step(world, 2)
    assert events == []


@pytest.mark.parametrize(
    ("plugin", "message"),
    [
        ("Recorder, fails_in: on_initialize", "RuntimeError: no luck"),
        ("Unfinished", "TypeError: Unfinished does not override on_initialize"),
    ],
)
def test_the_error_for_a_plugin_that_fails_to_start_has_its_line(files, plugin, message):
    write_model(files, "robot", f"name: a, type: {plugin}")

    refusal = files.refusal(
        "properties: {}\nlayers: []\nmodels: [{name: robot, model: robot.yaml}]"
    )

    assert refusal == f'robot.yaml:3: plugins[0] "a": does not start: {message}'

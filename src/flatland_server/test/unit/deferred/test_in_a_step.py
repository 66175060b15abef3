"""Models that are spawned, moved and deleted in a hook, which takes effect after the step."""

from collections import Counter

import numpy as np
import pytest
from deferred.stage import FAR, HOOKS, ends, plans, refusal, starts
from logged import errors

from flatland_server import Circle, _core
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose


@pytest.mark.parametrize("victim", ["robot", "post", "bystander"])
@pytest.mark.parametrize("hook", HOOKS)
def test_a_hook_deletes_a_model_at_the_end_of_the_step(stage, hook, victim):
    body = stage.body(victim)
    still_there = []

    def delete():
        stage.world.delete_model(victim)
        still_there.append((victim in stage.world.models, body.alive, ends[victim]))

    plans["robot", hook] = delete
    stage.run_until_done()

    assert still_there == [(True, True, 0)]
    assert victim not in stage.world.models
    with pytest.raises(_core.GoneError, match="this body has been deleted"):
        _ = body.pose


@pytest.mark.parametrize("mover", ["robot", "post", "bystander"])
@pytest.mark.parametrize("hook", HOOKS)
def test_a_hook_moves_a_model_at_the_end_of_the_step(stage, hook, mover):
    body = stage.body(mover)
    before = []

    def move():
        before.append(body.pose)
        stage.world.move_model(mover, FAR)
        before.append(body.pose)

    plans["robot", hook] = move
    stage.run_until_done()

    assert before[0] == before[1]
    assert tuple(stage.world.get_model(mover).pose) == pytest.approx(FAR)
    assert body.velocity == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("changed", ["robot", "post", "bystander"])
@pytest.mark.parametrize("hook", HOOKS)
def test_a_hook_changes_a_footprint_at_the_end_of_the_step(stage, hook, changed):
    model = stage.world.get_model(changed)
    before = []

    def change():
        model.set_footprint("base", 0, Circle((0.0, 0.0), 0.2))
        model.set_footprint("base", 0, layers=["walls"])
        before.append(model.footprint_revision)
        if changed != "robot":  # a change of a model that is deleted meanwhile does nothing
            stage.world.delete_model(changed)
            model.set_footprint("base", 0, Circle((0.0, 0.0), 0.3))

    plans["robot", hook] = change
    stage.run_until_done()

    assert before == [0]
    assert model.footprint_revision == 2
    if changed == "robot":
        [footprint] = model.base.config.footprints
        assert (footprint.shape.radius, footprint.layers) == (0.2, ("walls",))
        assert model.base.physics_body.mass == pytest.approx(np.pi * 0.04)


def test_a_hook_that_is_called_by_a_change_may_ask_for_others(stage):
    touching = Pose(0.95, 0.0, 0.0)
    stage.world.move_model("robot", touching)
    stage.run()
    plans["robot", "end_contact"] = lambda: stage.world.delete_model("post")

    stage.world.get_model("post").set_footprint("base", 0, layers=[])

    assert list(stage.world.models) == ["robot", "bystander"]


@pytest.mark.parametrize("hook", HOOKS)
def test_a_hook_spawns_a_model_at_the_end_of_the_step(stage, hook):
    seen = []

    def spawn():
        seen.append(stage.spawn("newcomer"))
        seen.append("newcomer" in stage.world.models)

    plans["robot", hook] = spawn
    stage.run_until_done()

    assert seen == [None, False]
    assert tuple(stage.world.get_model("newcomer").pose) == pytest.approx(FAR)
    assert starts["newcomer"] == 1


@pytest.mark.parametrize("hook", HOOKS)
def test_a_change_that_is_requested_twice_is_made_once(stage, hook, caplog):
    def ask():
        for _ in range(2):
            stage.world.delete_model("post")
            stage.world.delete_model("robot")
            stage.spawn("newcomer")

    plans["robot", hook] = ask
    stage.run_until_done()

    assert set(stage.world.models) == {"bystander", "newcomer"}
    assert errors(caplog) == [
        'the model "newcomer" is not spawned: a model named "newcomer" is already there'
    ]


@pytest.mark.parametrize("hook", HOOKS)
def test_changes_are_made_in_the_order_of_the_requests(stage, hook, caplog):
    def ask():
        world = stage.world
        world.move_model("post", FAR)
        world.move_model("post", Pose(1.0, 1.0, 1.0))
        world.move_model("bystander", FAR)
        world.delete_model("bystander")
        world.move_model("bystander", Pose())

    plans["robot", hook] = ask
    stage.run_until_done()

    assert tuple(stage.world.get_model("post").pose) == pytest.approx((1.0, 1.0, 1.0))
    assert set(stage.world.models) == {"robot", "post"}
    assert errors(caplog) == []


@pytest.mark.parametrize("hook", HOOKS)
def test_impossible_changes_are_refused_in_the_hook_itself(stage, hook):
    refusals = []

    def ask():
        world = stage.world
        for wish in (
            lambda: stage.spawn("post"),
            lambda: stage.spawn("no name"),
            lambda: stage.spawn("newcomer", model="none.yaml"),
            lambda: stage.spawn("newcomer", Pose(float("nan"), 0.0, 0.0)),
            lambda: world.delete_model("pots"),
            lambda: world.move_model("robot", Pose(float("inf"), 0.0, 0.0)),
        ):
            refusals.append(refusal(wish))
        entry = lambda: world.add_model(None)  # noqa: E731
        refusals.append(refusal(entry, FlatlandError))
        refusals.append(refusal(lambda: world.add_walls("walls", np.eye(1, 4)), FlatlandError))

    plans["robot", hook] = ask
    stage.run_until_done()

    assert refusals == [
        'a model named "post" is already there',
        'expected a name of letters, digits and "_" (it names a ROS topic), found "no name"',
        f"there is no file {stage.files.folder}/none.yaml",
        "expected a finite pose, found x=nan y=0.0 theta=0.0",
        'there is no model "pots" (did you mean "post"?)',
        "expected a finite pose, found x=inf y=0.0 theta=0.0",
        "add_model is for between steps; spawn_model may be called in a hook",
        "walls are put up between steps, not during one",
    ]
    assert set(stage.world.models) == {"robot", "post", "bystander"}


@pytest.mark.parametrize("hook", HOOKS)
def test_changes_that_fail_at_the_end_of_the_step_are_logged(stage, hook, caplog):
    def ask():
        stage.spawn("newcomer", model="bad.yaml")
        stage.spawn("distant", Pose(1e6, 0.0, 0.0))
        stage.world.move_model("post", Pose(1e6, 0.0, 0.0))
        stage.world.delete_model("bystander")

    plans["robot", hook] = ask
    stage.run_until_done()

    limit = "a position must be finite and within 100 km of the origin"
    assert errors(caplog) == [
        f'the model "newcomer" is not spawned: {stage.files.folder}/bad.yaml:5: plugins[2] "c": '
        "no luck",
        f'the model "distant" is not spawned: the model "distant" does not fit into the world: '
        f"{limit}",
        f'the model "post" is not moved: the model "post" cannot be there: {limit}',
    ]
    assert set(stage.world.models) == {"robot", "post"}
    starts.subtract(newcomer=1)  # it failed, and so was never shut down
    assert +starts - ends == Counter(robot=1, post=1)


def test_plugins_of_a_model_spawned_in_a_hook_run_next_step(stage):
    hooks = []
    plans["robot", "before_physics_step"] = lambda: stage.spawn("newcomer")
    for hook in ("before_physics_step", "after_physics_step"):
        plans["newcomer", hook] = lambda hook=hook: hooks.append(hook)

    stage.run()
    assert hooks == []
    stage.run()

    assert hooks == ["before_physics_step", "after_physics_step"]


def test_plugins_of_a_model_deleted_in_a_hook_finish_the_step(stage):
    hooks = []
    plans["robot", "before_physics_step"] = lambda: stage.world.delete_model("bystander")
    plans["bystander", "after_physics_step"] = lambda: hooks.append("after")

    stage.run()

    assert hooks == ["after"]
    assert "bystander" not in stage.world.models


def test_hundreds_of_models_may_be_spawned_in_one_hook(stage):
    def ask():
        config = stage.world.read_model(stage.files.folder / "ball.yaml")
        stage.world.read_model = lambda _: config  # reading the file takes most of the time
        for i in range(400):
            stage.spawn(f"m{i}", Pose(float(i), 5.0, 0.0))

    plans["robot", "before_physics_step"] = ask
    stage.run_until_done()

    assert len(stage.world.models) == 403
    for name in [name for name in stage.world.models if name.startswith("m")]:
        stage.world.delete_model(name)

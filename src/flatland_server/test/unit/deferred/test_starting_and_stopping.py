"""Models that are spawned, moved and deleted while plugins are started or stopped."""

import pytest
from deferred.stage import FAR, HOOKS, Stage, ends, plans, refusal, starts

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose


@pytest.mark.parametrize("victim", ["newcomer", "robot", "bystander"])
def test_a_plugin_may_delete_a_model_while_it_starts(stage, victim):
    plans["newcomer", "on_initialize"] = lambda: stage.world.delete_model(victim)

    stage.spawn("newcomer")

    expected = {"robot", "post", "bystander", "newcomer"} - {victim}
    assert set(stage.world.models) == expected
    assert ends[victim] == 1


@pytest.mark.parametrize("hook", HOOKS)
def test_a_model_spawned_by_a_hook_may_delete_itself(stage, hook):
    plans["robot", hook] = lambda: stage.spawn("newcomer")
    plans["newcomer", "on_initialize"] = lambda: stage.world.delete_model("newcomer")

    stage.run_until_done()

    assert set(stage.world.models) == {"robot", "post", "bystander"}


def test_a_starting_model_may_be_moved_and_spawn_others(stage):
    def ask():
        stage.world.move_model("newcomer", Pose(0.0, 3.0, 0.0))
        stage.world.move_model("bystander", FAR)
        assert stage.spawn("second") is stage.world.get_model("second")

    plans["newcomer", "on_initialize"] = ask

    stage.spawn("newcomer")

    poses = {name: tuple(model.pose) for name, model in stage.world.models.items()}
    assert poses["newcomer"] == pytest.approx((0.0, 3.0, 0.0))
    assert poses["bystander"] == poses["second"] == pytest.approx(FAR)


def test_a_stopping_model_may_delete_itself_and_spawn_another(stage):
    def ask():
        stage.world.delete_model("robot")
        stage.spawn("second")
        stage.world.delete_model("bystander")
        stage.world.move_model("robot", FAR)

    plans["robot", "on_shutdown"] = ask

    stage.world.delete_model("robot")

    assert set(stage.world.models) == {"post", "second"}
    assert ends["robot"] == 1


@pytest.mark.parametrize("hook", HOOKS)
def test_a_model_deleted_by_a_hook_may_spawn_another(stage, hook):
    plans["robot", hook] = lambda: stage.world.delete_model("robot")
    plans["robot", "on_shutdown"] = lambda: stage.spawn("second")

    stage.run_until_done()

    assert set(stage.world.models) == {"second", "post", "bystander"}


def test_two_models_may_delete_each_other_as_they_are_stopped(stage):
    plans["robot", "on_shutdown"] = lambda: stage.world.delete_model("post")
    plans["post", "on_shutdown"] = lambda: stage.world.delete_model("robot")

    stage.world.delete_model("robot")

    assert set(stage.world.models) == {"bystander"}


def test_the_name_of_a_model_is_in_use_until_it_is_deleted(stage):
    refusals = []
    plans["robot", "on_shutdown"] = lambda: refusals.append(refusal(lambda: stage.spawn("robot")))

    stage.world.delete_model("robot")
    assert refusals == ['a model named "robot" is already there']
    stage.spawn("robot")

    assert starts["robot"] == 2


def test_models_spawned_by_a_failing_model_are_deleted(stage):
    def ask():
        plans["second", "on_initialize"] = lambda: stage.spawn("third")
        stage.spawn("second")
        stage.world.delete_model("newcomer")

    plans["newcomer", "on_initialize"] = ask

    refusal(lambda: stage.spawn("newcomer", model="bad.yaml"), FlatlandError)

    assert set(stage.world.models) == {"robot", "post", "bystander"}
    assert (ends["second"], ends["third"]) == (1, 1)
    starts.subtract(newcomer=1)  # it failed, and so was never shut down
    stage.spawn("newcomer")


def test_models_spawned_by_a_failing_one_may_delete_each_other(stage):
    def ask():
        for name, other in (("second", "third"), ("third", "second")):
            stage.spawn(name)
            plans[name, "on_shutdown"] = lambda other=other: stage.world.delete_model(other)

    plans["newcomer", "on_initialize"] = ask

    refusal(lambda: stage.spawn("newcomer", model="bad.yaml"), FlatlandError)

    assert set(stage.world.models) == {"robot", "post", "bystander"}
    starts.subtract(newcomer=1)  # it failed, and so was never shut down


def test_a_plugin_of_the_world_may_spawn_models_as_it_is_started(files, stage):
    plugin = "{type: Founder, name: founder, model: ball.yaml}"
    starts.clear()

    world = files.load(f"properties: {{}}\nlayers: []\nplugins: [{plugin}]\n")

    assert set(world.models) == {"founded"}
    assert starts["founded"] == 1
    world.close()
    assert ends.pop("founded") == 1
    starts.clear()
    starts.update(stage.world.models.keys())


@pytest.mark.parametrize("victim", ["robot", "post", "bystander"])
def test_a_model_may_be_deleted_while_the_world_is_closed(files, simulate, victim):
    stage = Stage(files, simulate)
    plans["robot", "on_shutdown"] = lambda: stage.world.delete_model(victim)

    stage.world.close()
    stage.world.close()

    assert dict(ends) == {"robot": 1, "post": 1, "bystander": 1}
    assert stage.simulation.transport.topics == set()
    stage.run()


def test_nothing_is_spawned_while_the_world_is_closed(files, simulate):
    stage = Stage(files, simulate)
    plans["robot", "on_shutdown"] = lambda: stage.spawn("second")

    stage.world.close()

    assert starts == ends
    assert stage.simulation.transport.topics == set()
    assert stage.simulation.transport.subscribed == set()

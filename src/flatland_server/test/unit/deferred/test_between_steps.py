"""Models that are spawned, moved and deleted in callbacks, or when contacts end between steps."""

import numpy as np
import pytest
from deferred.stage import FAR, ends, plans, refusal
from logged import errors

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose

DELETIONS = ["robot", "post", "bystander"]


@pytest.mark.parametrize("victim", DELETIONS)
def test_a_callback_deletes_a_model_at_once(stage, victim):
    seen = []

    def delete():
        stage.world.delete_model(victim)
        seen.append((victim in stage.world.models, ends[victim]))

    plans["robot", "callback"] = delete
    stage.cue()

    assert seen == [(False, 1)]


def test_a_callback_spawns_or_moves_a_model_at_once(stage):
    seen = []

    def ask():
        seen.append(stage.spawn("newcomer"))
        stage.world.move_model("robot", FAR)
        seen.append(stage.world.get_model("robot").pose)

    plans["robot", "callback"] = ask
    stage.cue()

    assert seen[0] is stage.world.get_model("newcomer")
    assert tuple(seen[1]) == pytest.approx(FAR)


def test_a_plugin_failing_after_deleting_itself_ends_once(stage, caplog):
    def delete_and_fail():
        stage.world.delete_model("robot")
        raise RuntimeError("no luck")

    plans["robot", "callback"] = delete_and_fail
    stage.cue()
    stage.run()

    assert ends["robot"] == 1
    assert len(errors(caplog)) == 1
    assert '"robot/actor"' in errors(caplog)[0]


@pytest.mark.parametrize("victim", ["robot", "bystander"])
def test_end_contact_with_a_deleted_model_may_delete_models(stage, victim):
    plans["robot", "begin_contact"] = lambda: None
    stage.run_until_done()
    plans["robot", "end_contact"] = lambda: stage.world.delete_model(victim)

    stage.world.delete_model("post")

    assert plans == {}
    assert set(stage.world.models) == {"robot", "post", "bystander"} - {"post", victim}
    stage.check()


def test_models_may_be_spawned_in_end_contact_of_a_deleted_one(stage):
    plans["robot", "begin_contact"] = lambda: None
    stage.run_until_done()

    def ask():
        assert stage.spawn("newcomer") is None
        stage.world.move_model("robot", FAR)
        refusal(lambda: stage.world.delete_model("post"))
        refusal(lambda: stage.world.add_walls("walls", np.eye(1, 4)), FlatlandError)

    plans["robot", "end_contact"] = ask

    stage.world.delete_model("post")

    assert set(stage.world.models) == {"robot", "newcomer", "bystander"}
    assert tuple(stage.world.get_model("robot").pose) == pytest.approx(FAR)


def test_deletions_in_end_contact_may_chain_through_models(stage):
    for i in range(5):
        stage.spawn(f"m{i}", Pose(-2.0 - 0.19 * i, -2.0, 0.0))
    stage.run()
    for i in range(4):
        plans[f"m{i + 1}", "end_contact"] = lambda i=i: stage.world.delete_model(f"m{i + 1}")

    stage.world.delete_model("m0")

    assert set(stage.world.models) == {"robot", "post", "bystander"}

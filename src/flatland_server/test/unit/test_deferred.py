"""Models that are spawned, moved and deleted in the midst of things: hooks, callbacks, ends."""

import logging
from collections import Counter
from typing import Any, Callable, Dict, Iterator, List, Tuple

import numpy as np
import pytest

from flatland_server import _core
from flatland_server.exceptions import FlatlandError, ModelError
from flatland_server.geometry import Pose
from flatland_server.model_plugin import ModelPlugin
from flatland_server.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.world_plugin import WorldPlugin

HOOKS = (
    "before_physics_step",
    "begin_contact",
    "pre_solve",
    "post_solve",
    "end_contact",
    "after_physics_step",
)
FAR = Pose(-3.0, 2.0, 0.5)

plans: Dict[Tuple[str, str], Callable[[], None]] = {}
"""What a model's plugin does once in a hook: by (model, hook)."""

starts: "Counter[str]" = Counter()
ends: "Counter[str]" = Counter()
"""How often the plugins of a model were started and ended."""


class Actor(ModelPlugin):
    """Does in its hooks what is planned for them."""

    def on_initialize(self, config):
        starts[self.model.name] += 1
        self.node.advertise(f"{self.model.name}/{self.name}", str)
        self.node.subscribe("cue", str, lambda _: self._act("callback"))
        self.node.claim_frame("map", f"{self.model.name}/{self.name}")
        self._act("on_initialize")
        if config.get_bool("fails", False):
            raise config.error("no luck")

    def before_physics_step(self, timekeeper):
        self._act("before_physics_step")

    def begin_contact(self, contact):
        self._act("begin_contact")

    def pre_solve(self, contact, old_manifold):
        self._act("pre_solve")

    def post_solve(self, contact, impulse):
        self._act("post_solve")

    def end_contact(self, contact):
        self._act("end_contact")

    def after_physics_step(self, timekeeper):
        self._act("after_physics_step")

    def on_shutdown(self):
        ends[self.model.name] += 1
        self._act("on_shutdown")

    def _act(self, hook: str) -> None:
        plan = plans.pop((self.model.name, hook), None)
        if plan is not None:
            plan()


class Founder(WorldPlugin):
    """Puts a model into the world as that begins."""

    def on_initialize(self, config):
        self.founded = self.world.spawn_model(config.get_path("model"), "founded", "", Pose())


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    yield
    for each in (plans, starts, ends):
        each.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of this file."""
    return PluginLoader(
        PluginDeclaration(c.__name__, "test", f"{__name__}.{c.__name__}") for c in (Actor, Founder)
    )


class Stage:
    """A world where "robot" is about to bounce off "post", and "bystander" stands aside."""

    def __init__(self, files, simulate) -> None:
        self.files = files
        ball = "{type: circle, radius: 0.1, density: 1, restitution: 1}"
        square = "{type: polygon, points: [[0, -1], [1, -1], [1, 1], [0, 1]], density: 1}"
        plugin = "plugins: [{type: Actor, name: actor}]"
        files.write("ball.yaml", f"bodies: [{{name: base, footprints: [{ball}]}}]\n{plugin}\n")
        files.write(
            "post.yaml", f"bodies: [{{name: base, type: static, footprints: [{square}]}}]\n{plugin}"
        )
        files.write(
            "bad.yaml",
            f"bodies: [{{name: base, footprints: [{ball}]}}]\nplugins:\n"
            "  - {type: Actor, name: a}\n  - {type: Actor, name: b}\n"
            "  - {type: Actor, name: c, fails: true}\n",
        )
        self.world = files.load("properties: {}\nlayers: [{name: walls}]\n")
        self.world.add_walls("walls", np.array([[-9.0, -9.0, 9.0, -9.0]]))
        self.simulation = simulate(self.world)
        self.spawn("robot", Pose(0.8, 0.0, 0.0)).base.physics_body.velocity = (2.0, 0.0, 0.0)
        self.spawn("post", Pose(1.0, 0.0, 0.0), "post.yaml")
        self.spawn("bystander", Pose(-1.0, 0.0, 0.0))

    def spawn(self, name: str, pose: Pose = FAR, model: str = "ball.yaml"):
        return self.world.spawn_model(self.files.folder / model, name, "", pose)

    def body(self, name: str) -> _core.Body:
        return self.world.get_model(name).base.physics_body

    def run(self, seconds=None) -> None:
        self.simulation.run(seconds)

    def run_until_done(self) -> None:
        """Steps until all that is planned has begun, and to the end of that step."""
        for _ in range(100):
            self.run()
            if not plans:
                return
        raise AssertionError(f"these hooks were not called: {list(plans)}")

    def check(self) -> None:
        """Nothing is there but the models, and each that is gone was ended once."""
        world = self.world
        assert world.physics.body_count == 1 + len(world.models)  # and the wall
        assert len(list(world.entities)) == 1 + len(world.models)
        topics = {f"/{name}/actor" for name in world.models}
        assert self.simulation.transport.topics == topics
        assert self.simulation.transport.subscribed == ({"/cue"} if world.models else set())
        assert starts - ends == Counter(world.models.keys())
        assert ends - starts == Counter()
        assert world.plugin_failures == []


@pytest.fixture
def stage(files, simulate) -> Iterator[Stage]:
    stage = Stage(files, simulate)
    yield stage
    assert plans == {}
    stage.check()
    stage.run(0.5)
    stage.check()


def errors(caplog: pytest.LogCaptureFixture) -> List[str]:
    """The errors logged so far."""
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.ERROR]


def refusal(ask: Callable[[], Any], kind=ModelError) -> str:
    with pytest.raises(kind) as caught:
        ask()
    return str(caught.value)


# In a step


@pytest.mark.parametrize("victim", ["robot", "post", "bystander"])
@pytest.mark.parametrize("hook", HOOKS)
def test_a_model_that_is_deleted_in_a_hook_goes_at_the_end_of_the_step(stage, hook, victim):
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
def test_a_model_that_is_moved_in_a_hook_is_moved_at_the_end_of_the_step(stage, hook, mover):
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


@pytest.mark.parametrize("hook", HOOKS)
def test_a_model_that_is_spawned_in_a_hook_comes_at_the_end_of_the_step(stage, hook):
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
def test_what_is_asked_for_twice_is_done_once(stage, hook, caplog):
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
def test_what_is_asked_for_is_done_in_that_order(stage, hook, caplog):
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
def test_what_cannot_be_is_refused_in_the_hook_itself(stage, hook):
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
def test_what_fails_only_at_the_end_of_the_step_is_logged(stage, hook, caplog):
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
        f'the model "post" cannot be there: {limit}',
    ]
    assert set(stage.world.models) == {"robot", "post"}
    starts.subtract(newcomer=1)  # the one that failed; it was never ended
    assert +starts - ends == Counter(robot=1, post=1)


def test_a_model_that_is_spawned_in_a_hook_lives_from_the_next_step_on(stage):
    hooks = []
    plans["robot", "before_physics_step"] = lambda: stage.spawn("newcomer")
    for hook in ("before_physics_step", "after_physics_step"):
        plans["newcomer", hook] = lambda hook=hook: hooks.append(hook)

    stage.run()
    assert hooks == []
    stage.run()

    assert hooks == ["before_physics_step", "after_physics_step"]


def test_the_hooks_of_a_model_that_is_deleted_in_a_step_go_on_to_its_end(stage):
    hooks = []
    plans["robot", "before_physics_step"] = lambda: stage.world.delete_model("bystander")
    plans["bystander", "after_physics_step"] = lambda: hooks.append("after")

    stage.run()

    assert hooks == ["after"]
    assert "bystander" not in stage.world.models


# Between steps


DELETIONS = ["robot", "post", "bystander"]


@pytest.mark.parametrize("victim", DELETIONS)
def test_a_model_that_is_deleted_in_a_callback_goes_at_once(stage, victim):
    seen = []

    def delete():
        stage.world.delete_model(victim)
        seen.append((victim in stage.world.models, ends[victim]))

    plans["robot", "callback"] = delete
    stage.simulation.transport.send("/cue", "go")
    stage.simulation.transport.process()

    assert seen == [(False, 1)]


def test_a_model_that_is_spawned_or_moved_in_a_callback_is_there_at_once(stage):
    seen = []

    def ask():
        seen.append(stage.spawn("newcomer"))
        stage.world.move_model("robot", FAR)
        seen.append(stage.world.get_model("robot").pose)

    plans["robot", "callback"] = ask
    stage.simulation.transport.send("/cue", "go")
    stage.simulation.transport.process()

    assert seen[0] is stage.world.get_model("newcomer")
    assert tuple(seen[1]) == pytest.approx(FAR)


def test_no_callback_comes_after_the_end_of_its_plugin(stage):
    plans["robot", "callback"] = lambda: stage.world.delete_model("bystander")
    late = []
    plans["bystander", "callback"] = lambda: late.append("called")

    stage.simulation.transport.send("/cue", "go")
    stage.run()

    assert late == []
    plans.clear()


def test_a_plugin_that_fails_after_it_has_deleted_its_own_model_is_ended_once(stage, caplog):
    def delete_and_fail():
        stage.world.delete_model("robot")
        raise RuntimeError("no luck")

    plans["robot", "callback"] = delete_and_fail
    stage.simulation.transport.send("/cue", "go")
    stage.run()

    assert ends["robot"] == 1
    assert len(errors(caplog)) == 1
    assert '"robot/actor"' in errors(caplog)[0]


@pytest.mark.parametrize("victim", ["robot", "bystander"])
def test_models_are_deleted_as_the_contact_with_a_deleted_model_ends(stage, victim):
    plans["robot", "begin_contact"] = lambda: None
    stage.run_until_done()
    plans["robot", "end_contact"] = lambda: stage.world.delete_model(victim)

    stage.world.delete_model("post")

    assert plans == {}
    assert set(stage.world.models) == {"robot", "post", "bystander"} - {"post", victim}
    stage.check()


def test_models_are_spawned_and_moved_as_the_contact_with_a_deleted_model_ends(stage):
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


def test_a_row_of_models_each_deletes_the_next_as_their_contact_ends(stage):
    for i in range(5):
        stage.spawn(f"m{i}", Pose(-2.0 - 0.19 * i, -2.0, 0.0))
    stage.run()
    for i in range(4):
        plans[f"m{i + 1}", "end_contact"] = lambda i=i: stage.world.delete_model(f"m{i + 1}")

    stage.world.delete_model("m0")

    assert set(stage.world.models) == {"robot", "post", "bystander"}


# While models are started and stopped


@pytest.mark.parametrize("victim", ["newcomer", "robot", "bystander"])
def test_a_model_may_be_deleted_by_a_plugin_that_is_just_being_started(stage, victim):
    plans["newcomer", "on_initialize"] = lambda: stage.world.delete_model(victim)

    stage.spawn("newcomer")

    expected = {"robot", "post", "bystander", "newcomer"} - {victim}
    assert set(stage.world.models) == expected
    assert ends[victim] == 1


@pytest.mark.parametrize("hook", HOOKS)
def test_a_model_may_delete_itself_as_it_comes_at_the_end_of_a_step(stage, hook):
    plans["robot", hook] = lambda: stage.spawn("newcomer")
    plans["newcomer", "on_initialize"] = lambda: stage.world.delete_model("newcomer")

    stage.run_until_done()

    assert set(stage.world.models) == {"robot", "post", "bystander"}


def test_a_model_may_be_moved_and_others_spawned_as_it_is_started(stage):
    def ask():
        stage.world.move_model("newcomer", Pose(0.0, 3.0, 0.0))
        stage.world.move_model("bystander", FAR)
        assert stage.spawn("second") is stage.world.get_model("second")

    plans["newcomer", "on_initialize"] = ask

    stage.spawn("newcomer")

    poses = {name: tuple(model.pose) for name, model in stage.world.models.items()}
    assert poses["newcomer"] == pytest.approx((0.0, 3.0, 0.0))
    assert poses["bystander"] == poses["second"] == pytest.approx(FAR)


def test_a_model_may_delete_itself_and_spawn_another_as_it_is_started(stage):
    def ask():
        stage.world.delete_model("newcomer")
        stage.spawn("second")

    plans["newcomer", "on_initialize"] = ask

    stage.spawn("newcomer")

    assert set(stage.world.models) == {"robot", "post", "bystander", "second"}


def test_a_model_may_delete_itself_and_spawn_another_as_it_is_stopped(stage):
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
def test_a_model_that_is_stopped_at_the_end_of_a_step_may_have_another_follow(stage, hook):
    plans["robot", hook] = lambda: stage.world.delete_model("robot")
    plans["robot", "on_shutdown"] = lambda: stage.spawn("second")

    stage.run_until_done()

    assert set(stage.world.models) == {"second", "post", "bystander"}


def test_two_models_may_delete_each_other_as_they_are_stopped(stage):
    plans["robot", "on_shutdown"] = lambda: stage.world.delete_model("post")
    plans["post", "on_shutdown"] = lambda: stage.world.delete_model("robot")

    stage.world.delete_model("robot")

    assert set(stage.world.models) == {"bystander"}


def test_the_name_of_a_model_is_taken_until_it_is_gone(stage):
    refusals = []
    plans["robot", "on_shutdown"] = lambda: refusals.append(refusal(lambda: stage.spawn("robot")))

    stage.world.delete_model("robot")
    assert refusals == ['a model named "robot" is already there']
    stage.spawn("robot")

    assert starts["robot"] == 2


def test_what_a_plugin_had_spawned_goes_when_its_own_model_does_not_start(stage):
    def ask():
        plans["second", "on_initialize"] = lambda: stage.spawn("third")
        stage.spawn("second")
        stage.world.delete_model("newcomer")

    plans["newcomer", "on_initialize"] = ask

    refusal(lambda: stage.spawn("newcomer", model="bad.yaml"), FlatlandError)

    assert set(stage.world.models) == {"robot", "post", "bystander"}
    assert (ends["second"], ends["third"]) == (1, 1)
    starts.subtract(newcomer=1)  # the one that failed; it was never ended
    stage.spawn("newcomer")


def test_models_that_a_failing_one_had_spawned_may_delete_each_other_as_they_go(stage):
    def ask():
        for name, other in (("second", "third"), ("third", "second")):
            stage.spawn(name)
            plans[name, "on_shutdown"] = lambda other=other: stage.world.delete_model(other)

    plans["newcomer", "on_initialize"] = ask

    refusal(lambda: stage.spawn("newcomer", model="bad.yaml"), FlatlandError)

    assert set(stage.world.models) == {"robot", "post", "bystander"}
    starts.subtract(newcomer=1)  # the one that failed; it was never ended


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


# At the end of the world


@pytest.mark.parametrize("victim", ["robot", "post", "bystander"])
def test_a_model_may_be_deleted_as_the_world_ends(files, simulate, victim):
    stage = Stage(files, simulate)
    plans["robot", "on_shutdown"] = lambda: stage.world.delete_model(victim)

    stage.world.close()
    stage.world.close()

    assert dict(ends) == {"robot": 1, "post": 1, "bystander": 1}
    assert stage.simulation.transport.topics == set()
    stage.run()


def test_nothing_is_spawned_any_more_as_the_world_ends(files, simulate):
    stage = Stage(files, simulate)
    plans["robot", "on_shutdown"] = lambda: stage.spawn("second")

    stage.world.close()

    assert starts == ends
    assert stage.simulation.transport.topics == set()
    assert stage.simulation.transport.subscribed == set()

"""Spawning, moving and deleting models, with their topics and frames; failures leave no trace."""

import math
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from logged import warnings
from world.parts import BODIES, EMPTY, spawn, state

from flatland_server import _core
from flatland_server.exceptions import ModelError, YamlError
from flatland_server.geometry import Pose
from flatland_server.models.footprint import Circle
from flatland_server.models.joint import JointConfig
from flatland_server.models.model import ModelConfig
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.world_config import ModelEntry


@pytest.mark.parametrize(
    ("model", "options", "message"),
    [
        ("good.yaml", {"name": "here"}, 'a model named "here" is already there'),
        ("good.yaml", {"pose": Pose(math.nan)}, "expected a finite pose, found x=nan y=0.0"),
        ("none.yaml", {}, "there is no file {folder}/none.yaml"),
        (
            "good.yaml",
            {"pose": Pose(1e6)},
            'the model "robot" does not fit into the world: a position must be finite and within',
        ),
    ],
)
def test_a_failed_spawn_leaves_the_world_unchanged(models, model, options, message):
    world = models.load(EMPTY)
    spawn(models, world, "good.yaml", "here")
    before = state(world)

    with pytest.raises(ModelError, match=re.escape(message.format(folder=models.folder))):
        spawn(models, world, model, **{"name": "robot", **options})

    assert state(world) == before


@pytest.mark.parametrize("name", ["robot\n", "robot/", "/robot", "ro//bot", "röbot", "a.b", "~a"])
def test_a_name_that_cannot_be_part_of_a_topic_is_refused(models, name):
    world = models.load(EMPTY)

    with pytest.raises(ModelError, match="expected a name of letters"):
        spawn(models, world, "good.yaml", name)


@pytest.mark.parametrize("namespace", ["1robot", "_robot", "a//b", "a b", "~~a", "a-b"])
def test_a_namespace_that_ros_would_refuse_is_refused(models, namespace):
    world = models.load(EMPTY)

    with pytest.raises(ModelError, match="expected a namespace of letters"):
        spawn(models, world, "good.yaml", "robot", namespace=namespace)


def test_deleting_a_model_removes_its_bodies_topics_and_frames(models, simulate, caplog):
    world = models.load(EMPTY)
    spawn(models, world, "good.yaml", "stays", namespace="other")
    before = state(world)
    robot = spawn(models, world, "good.yaml", "robot", pose=Pose(1, 0, 0))
    body = robot.base.physics_body
    simulate(world).run()

    world.delete_model("robot")

    assert state(world) == before
    with pytest.raises(_core.GoneError):
        _ = body.pose
    spawn(models, world, "good.yaml", "heir", pose=Pose(1, 0, 0))  # publishes the same frames
    simulate(world).run()
    assert warnings(caplog) == []


def test_the_error_for_an_unknown_model_suggests_the_nearest(models):
    world = models.load(EMPTY)
    spawn(models, world, "good.yaml", "turtlebot")

    for act, *more in ((world.delete_model,), (world.move_model, Pose()), (world.get_model,)):
        with pytest.raises(ModelError) as caught:
            act("turtelbot", *more)
        assert str(caught.value) == 'there is no model "turtelbot" (did you mean "turtlebot"?)'


@pytest.mark.parametrize("pose", [Pose(math.nan, 0.0, 0.0), Pose(0.0, math.inf, 0.0)])
def test_a_model_is_not_moved_to_a_pose_that_is_not_finite(models, pose):
    world = models.load(EMPTY)
    robot = spawn(models, world, "good.yaml", "robot", pose=Pose(1.0, 2.0, 3.0))

    with pytest.raises(ModelError, match="expected a finite pose, found "):
        world.move_model("robot", pose)

    assert tuple(robot.pose) == pytest.approx((1.0, 2.0, 3.0))


def test_models_of_one_file_are_separated_by_their_namespaces(models, simulate, transport, caplog):
    entries = "".join(
        f"  - {{name: {name}, model: good.yaml, namespace: {namespace}, pose: [{x}, 0, 0]}}\n"
        for name, namespace, x in (("a", "robot1", 1), ("b", "robot2", 2), ("c", "''", 3))
    )
    world = models.load(f"{EMPTY}models:\n{entries}", transport=transport)

    simulate(world).run()

    assert transport.topics == {"/robot1/chatter", "/robot2/chatter", "/chatter"}
    assert transport.subscribed == {"/robot1/command", "/robot2/command", "/command"}
    assert transport.last("/robot2/chatter") == "b at 5000000"
    frames = {child: (t.parent, t.pose.x) for child, t in transport.transforms.items()}
    assert frames == {
        "robot1_base": ("odom", 1.0),
        "robot2_base": ("odom", 2.0),
        "base": ("odom", 3.0),
    }
    assert warnings(caplog) == []


def test_one_configuration_can_be_used_for_several_models(models, simulate, transport):
    world = models.load(EMPTY, transport=transport)
    config = ModelConfig.from_file(models.folder / "good.yaml", world.registry)

    added = [
        world.add_model(ModelEntry(name, name, Pose(x, 0.0, 0.0), config))
        for name, x in (("one", 1.0), ("two", 2.0))
    ]
    simulate(world).run()

    assert list(world.models.values()) == added
    assert [model.pose.x for model in added] == pytest.approx([1.0, 2.0])
    assert transport.topics == {"/one/chatter", "/two/chatter"}


def test_a_model_that_cannot_be_made_leaves_no_body_behind(models):
    world = models.load(EMPTY)
    good = ModelConfig.from_file(models.folder / "good.yaml", world.registry)
    base, head = good.bodies
    point = replace(head.footprints[0], shape=Circle((0.0, 0.0), 0.0))
    with_point = replace(head, footprints=(head.footprints[0], point))
    joint = JointConfig("weld", "arm", (1.0,) * 4, False, (base.name, "none"), ((0.0, 0.0),) * 2)
    before = state(world)

    for config, error, message in (
        (replace(good, bodies=(base, with_point)), ModelError, '"robot" does not fit .*: a radius'),
        (replace(good, joints=(joint,)), KeyError, "none"),  # an unexpected error
    ):
        with pytest.raises(error, match=message):
            world.add_model(ModelEntry("robot", "", Pose(), config))
        assert state(world) == before


def test_all_plugins_that_do_not_start_are_reported_at_once(models):
    models.write("worse.yaml", f"{BODIES}plugins:\n  - {{type: Talkr, name: a}}\n")
    entries = "models: [{name: a, model: bad.yaml}, {name: b, model: worse.yaml}]"

    assert models.refusal(EMPTY + entries).splitlines() == [
        'bad.yaml:11: plugins[2] "c": no luck',
        'worse.yaml:9: plugins[0].type: unknown plugin type "Talkr" (did you mean "Talker"?); '
        "there are: Failing, Herald, Talker",
    ]


# Spawning in two parts: reading on any thread, and adding on the simulation's.


def test_reading_an_entry_changes_nothing(models):
    world = models.load(EMPTY)
    before = state(world)

    entry = world.read_model_entry(models.folder / "good.yaml", "robot", "ns", Pose(1.0, 2.0, 0.5))

    assert (entry.name, entry.namespace, entry.pose) == ("robot", "ns", Pose(1.0, 2.0, 0.5))
    assert state(world) == before
    world.add_model(entry)
    assert world.get_model("robot").pose == pytest.approx(Pose(1.0, 2.0, 0.5))


def test_the_second_entry_of_a_name_is_refused(models):
    world = models.load(EMPTY)
    path = models.folder / "good.yaml"
    with ThreadPoolExecutor(2) as pool:
        read = lambda _: world.read_model_entry(path, "robot", "", Pose())  # noqa: E731
        entries = list(pool.map(read, range(2)))

    world.add_model(entries[0])
    with pytest.raises(ModelError, match='a model named "robot" is already there'):
        world.add_model(entries[1])

    assert list(world.models) == ["robot"]


def test_plugin_classes_are_imported_by_reading(models, tmp_path, monkeypatch):
    (tmp_path / "imported_late.py").write_text("from world.parts import Talker as Late\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    loader = PluginLoader([PluginDeclaration("Late", "tests", "imported_late.Late")])
    world = models.load(EMPTY, loader=loader)
    path = models.write("late.yaml", f"{BODIES}plugins: [{{type: Late, name: late}}]")
    assert "imported_late" not in sys.modules

    world.read_model_entry(path, "robot", "", Pose())

    assert sys.modules.pop("imported_late")


def test_adding_a_model_reports_an_unknown_plugin_with_its_line(models):
    world = models.load(EMPTY)
    path = models.write("late.yaml", f"{BODIES}plugins:\n- {{type: Lazer, name: laser}}")
    entry = world.read_model_entry(path, "robot", "", Pose())

    with pytest.raises(YamlError, match=r'late\.yaml:9: .*unknown plugin type "Lazer"'):
        world.add_model(entry)

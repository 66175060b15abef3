"""The world: loaded wholly or not at all; models come, are moved and go with all that is theirs."""

import logging
import math
from typing import Any, List

import numpy as np
import pytest

from flatland_server import _core
from flatland_server.exceptions import FlatlandError, ModelError
from flatland_server.geometry import Pose, Transform
from flatland_server.local_transport import LocalTransport
from flatland_server.model import ModelConfig
from flatland_server.model_plugin import ModelPlugin
from flatland_server.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.world import World
from flatland_server.world_config import ModelEntry
from flatland_server.world_plugin import WorldPlugin

BODIES = """
bodies:
  - name: base
    footprints: [{type: circle, radius: 0.1, density: 1}]
  - name: head
    footprints: [{type: circle, radius: 0.1, density: 1}]
joints:
  - {type: weld, name: neck, bodies: [{name: base, anchor: [0, 0]}, {name: head, anchor: [0, 0]}]}
"""
EMPTY = "properties: {}\nlayers: []\n"


class Talker(ModelPlugin):
    """Publishes to "chatter", listens to "command" and publishes the frame "base"."""

    def on_initialize(self, config):
        self._publisher = self.node.advertise("chatter", str)
        self.node.subscribe("command", str, lambda _: None)
        self.node.claim_frame("odom", self.name_space_tf("base"))

    def after_physics_step(self, timekeeper):
        self._publisher.publish(f"{self.model.name} at {timekeeper.nanoseconds}")
        frame = self.name_space_tf("base")
        self.node.send_transform(
            Transform(timekeeper.nanoseconds, "odom", frame, self.model.base.pose)
        )


class Failing(ModelPlugin):
    """Opens a topic and then does not start."""

    def on_initialize(self, config):
        self.node.advertise("half_open", str)
        self.node.subscribe("half_heard", str, lambda _: None)
        self.node.claim_frame("odom", "half_placed")
        raise config.error("no luck")


class Herald(WorldPlugin):
    """Publishes how many models there are."""

    def on_initialize(self, config):
        self._publisher = self.node.advertise("population", int)

    def after_physics_step(self, timekeeper):
        self._publisher.publish(len(self.world.models))


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of this file."""
    return PluginLoader(
        PluginDeclaration(cls.__name__, "test", f"{__name__}.{cls.__name__}")
        for cls in (Talker, Failing, Herald)
    )


@pytest.fixture
def transport() -> LocalTransport:
    return LocalTransport()


@pytest.fixture
def models(files):
    """A folder with the models good.yaml and bad.yaml, whose third plugin does not start."""
    files.write("plain.yaml", BODIES)
    good = f"{BODIES}plugins:\n  - {{type: Talker, name: a}}\n"
    files.write("good.yaml", good)
    files.write(
        "bad.yaml", f"{good}  - {{type: Talker, name: b}}\n  - {{type: Failing, name: c}}\n"
    )
    return files


def spawn(files, world: World, model: str, name: str, **options: Any):
    """Spawns a model without a namespace at the origin, if not told otherwise."""
    namespace, pose = options.get("namespace", ""), options.get("pose", Pose())
    return world.spawn_model(files.folder / model, name, namespace, pose)


def state(world: World) -> tuple:
    """All that a failed spawn must leave as it was."""
    assert isinstance(world.transport, LocalTransport)
    return (
        list(world.models),
        world.physics.body_count,
        world.physics.joint_count,
        world.transport.topics,
        world.transport.subscribed,
    )


def warnings(caplog: pytest.LogCaptureFixture) -> List[str]:
    """What was warned of so far."""
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]


def test_a_model_whose_third_plugin_fails_leaves_no_trace(models, simulate, caplog):
    world = models.load(EMPTY)
    before = state(world)

    with pytest.raises(FlatlandError) as caught:
        spawn(models, world, "bad.yaml", "robot")

    message = f'{models.folder}/bad.yaml:11: plugins[2] "c": no luck'
    assert str(caught.value) == message
    assert state(world) == before
    # Nor a claim to its frames: another robot may have them without a warning.
    caplog.clear()
    spawn(models, world, "good.yaml", "heir")
    simulate(world).run()
    assert warnings(caplog) == []
    spawn(models, world, "plain.yaml", "robot")


def test_a_world_whose_second_model_fails_leaves_no_topic(models, transport):
    entries = "models: [{name: a, model: good.yaml}, {name: b, model: bad.yaml}]"

    with pytest.raises(FlatlandError, match="no luck"):
        models.load(EMPTY + entries, transport=transport)

    assert (transport.topics, transport.subscribed) == (set(), set())


@pytest.mark.parametrize(
    ("model", "options", "message"),
    [
        pytest.param(
            "good.yaml", {"name": "here"}, 'a model named "here" is already there', id="taken"
        ),
        pytest.param("good.yaml", {"name": ""}, "expected a name, found an empty one", id="empty"),
        pytest.param(
            "good.yaml",
            {"name": "my robot"},
            'expected a name of letters, digits and "_" (it names a ROS topic), found "my robot"',
            id="a space",
        ),
        pytest.param(
            "good.yaml",
            {"namespace": "my robots"},
            'expected a namespace of letters, digits and "_", beginning with a letter, '
            'found "my robots"',
            id="a namespace with a space",
        ),
        pytest.param(
            "good.yaml",
            {"pose": Pose(math.nan, 0.0, 0.0)},
            "expected a finite pose, found x=nan y=0.0 theta=0.0",
            id="NaN",
        ),
        pytest.param(
            "good.yaml",
            {"pose": Pose(0.0, 0.0, math.inf)},
            "expected a finite pose, found x=0.0 y=0.0 theta=inf",
            id="an infinite heading",
        ),
        pytest.param("none.yaml", {}, "there is no file {folder}/none.yaml", id="no file"),
        pytest.param(
            "good.yaml",
            {"pose": Pose(1e6, 0.0, 0.0)},
            'the model "robot" does not fit into the world: '
            "a position must be finite and within 100 km of the origin",
            id="too far",
        ),
    ],
)
def test_a_model_that_cannot_be_spawned_leaves_the_world_as_it_was(models, model, options, message):
    world = models.load(EMPTY)
    spawn(models, world, "good.yaml", "here")
    before = state(world)

    with pytest.raises(ModelError) as caught:
        spawn(models, world, model, **{"name": "robot", **options})

    assert str(caught.value) == message.format(folder=models.folder)
    assert state(world) == before


@pytest.mark.parametrize("name", ["robot\n", "robot/", "/robot", "ro//bot", "röbot", "a.b", "~a"])
def test_a_name_that_cannot_be_part_of_a_topic_is_refused(models, name):
    world = models.load(EMPTY)

    with pytest.raises(ModelError, match="expected a name of letters"):
        spawn(models, world, "good.yaml", name)


@pytest.mark.parametrize("namespace", ["1robot", "_robot", "a//b", "a b", "~a", "a-b"])
def test_a_namespace_that_ros_would_refuse_is_refused(models, namespace):
    world = models.load(EMPTY)

    with pytest.raises(ModelError, match="expected a namespace of letters"):
        spawn(models, world, "good.yaml", "robot", namespace=namespace)


def test_a_spawned_model_stands_where_it_was_put(models):
    world = models.load(EMPTY)

    robot = spawn(models, world, "good.yaml", "robot", pose=Pose(1.0, -2.0, 0.5))

    assert tuple(robot.pose) == pytest.approx((1.0, -2.0, 0.5))
    assert world.get_model("robot") is robot


def test_a_deleted_model_takes_its_bodies_topics_and_frames_along(models, simulate, caplog):
    world = models.load(EMPTY)
    spawn(models, world, "good.yaml", "stays", namespace="other")
    before = state(world)
    robot = spawn(models, world, "good.yaml", "robot")
    body = robot.base.physics_body
    simulate(world).run()

    world.delete_model("robot")

    assert state(world) == before
    with pytest.raises(_core.GoneError):
        _ = body.pose
    spawn(models, world, "good.yaml", "heir")  # has its frames
    simulate(world).run()
    assert warnings(caplog) == []


def test_a_deleted_models_name_is_free(models):
    world = models.load(EMPTY)
    for _ in range(3):
        spawn(models, world, "good.yaml", "robot")
        world.delete_model("robot")

    assert state(world) == ([], 0, 0, set(), set())


@pytest.mark.parametrize("action", ["delete", "move", "get"])
def test_a_model_that_is_not_there_is_answered_by_the_nearest(models, action):
    world = models.load(EMPTY)
    spawn(models, world, "good.yaml", "turtlebot")
    actions = {
        "delete": world.delete_model,
        "move": lambda name: world.move_model(name, Pose()),
        "get": world.get_model,
    }

    with pytest.raises(ModelError) as caught:
        actions[action]("turtelbot")

    assert str(caught.value) == 'there is no model "turtelbot" (did you mean "turtlebot"?)'


@pytest.mark.parametrize("pose", [Pose(math.nan, 0.0, 0.0), Pose(0.0, math.inf, 0.0)])
def test_a_model_is_not_moved_to_a_pose_that_is_none(models, pose):
    world = models.load(EMPTY)
    robot = spawn(models, world, "good.yaml", "robot", pose=Pose(1.0, 2.0, 3.0))

    with pytest.raises(ModelError, match="expected a finite pose, found "):
        world.move_model("robot", pose)

    assert tuple(robot.pose) == pytest.approx((1.0, 2.0, 3.0))


def test_models_of_one_file_are_kept_apart_by_their_namespaces(models, simulate, transport, caplog):
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


def test_a_plugin_of_the_world_knows_the_world(models, simulate, transport):
    text = f"{EMPTY}plugins: [{{type: Herald, name: herald}}]\n"
    world = models.load(text + "models: [{name: a, model: plain.yaml}]", transport=transport)
    spawn(models, world, "plain.yaml", "b")

    simulate(world).run()

    assert transport.last("/population") == 2


def test_a_closed_world_has_no_topics(models, transport):
    world = models.load(f"{EMPTY}models: [{{name: a, model: good.yaml}}]", transport=transport)

    world.close()

    assert (transport.topics, transport.subscribed) == (set(), set())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        pytest.param("layers: []", '1: the required key "properties" is missing', id="properties"),
        pytest.param("properties: {}", '1: the required key "layers" is missing', id="layers"),
        pytest.param(
            "properties: {velocity_iteration: 5}\nlayers: []",
            '1: properties: unknown key "velocity_iteration" (did you mean "velocity_iterations"?)',
            id="unknown property",
        ),
        pytest.param(
            "properties: {position_iterations: 0}\nlayers: []",
            "1: properties.position_iterations: expected a whole number of 1 or more, found 0",
            id="no iteration",
        ),
        pytest.param(
            f"{EMPTY}model: []", '3: unknown key "model" (did you mean "models"?)', id="unknown key"
        ),
        pytest.param(
            f"{EMPTY}models:" + 2 * "\n  - {name: a, model: plain.yaml}",
            '5: models[1].name: the name "a" is given twice',
            id="two models of one name",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a, model: none.yaml}}",
            "4: models[0].model: expected a file, but none.yaml is not there",
            id="no model file",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a, model: plain.yaml, pose: foo}}",
            '4: models[0].pose: expected [x, y, yaw], found "foo"',
            id="no pose",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a b, model: plain.yaml}}",
            '4: models[0].name: expected a name of letters, digits and "_" '
            '(it names a ROS topic), found "a b"',
            id="a name with a space",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a, model: plain.yaml, namespace: 1a}}",
            "4: models[0].namespace: expected a namespace of letters, digits and "
            '"_", beginning with a letter, found "1a"',
            id="a namespace that begins with a digit",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a, modle: plain.yaml}}",
            '4: models[0] "a": the required key "model" is missing\n'
            'world.yaml:4: models[0] "a": unknown key "modle" (did you mean "model"?)',
            id="a model without a file",
        ),
        pytest.param(
            f"{EMPTY}plugins:\n  - {{type: Talker, name: a}}",
            f'4: plugins[0].type: "Talker" is not a WorldPlugin: {__name__}.Talker',
            id="a model's plugin for the world",
        ),
    ],
)
def test_a_wrong_world_is_refused_at_its_line(models, text, message):
    assert models.refusal(text) == f"world.yaml:{message}"


def test_all_that_is_wrong_in_all_files_is_said_at_once(models):
    models.write("wall.yaml", "type: line_segments\ndata: wall.dat\nscale: 0\norigin: foo\n")
    models.write("wall.dat", "")
    models.write("flawed.yaml", "bodies: [{name: base, footprints: []}]\njoints: 3\n")
    text = """\
properties: {friction: 1}
layers: [{name: a, map: wall.yaml}]
models:
  - {name: a, model: flawed.yaml}
  - {name: a, model: plain.yaml}
"""

    assert models.refusal(text).splitlines() == [
        'world.yaml:1: properties: unknown key "friction"',
        'wall.yaml:4: origin: expected [x, y, yaw], found "foo"',
        "wall.yaml:3: scale: expected a number above 0, found 0",
        "flawed.yaml:2: joints: expected a list, found 3",
        'world.yaml:5: models[1].name: the name "a" is given twice',
    ]


def test_all_plugins_that_do_not_start_are_named_at_once(models):
    models.write("worse.yaml", f"{BODIES}plugins:\n  - {{type: Talkr, name: a}}\n")
    entries = "models: [{name: a, model: bad.yaml}, {name: b, model: worse.yaml}]"

    assert models.refusal(EMPTY + entries).splitlines() == [
        'bad.yaml:11: plugins[2] "c": no luck',
        'worse.yaml:9: plugins[0].type: unknown plugin type "Talkr" (did you mean "Talker"?); '
        "there are: Failing, Herald, Talker",
    ]


def test_a_number_of_iterations_that_box2d_cannot_count_to_is_refused(models):
    message = models.refusal("properties:\n  velocity_iterations: 3000000000\nlayers: []\n")

    assert message.startswith("world.yaml:2: properties.velocity_iterations: expected ")


def test_a_world_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FlatlandError) as caught:
        World.from_file(tmp_path / "world.yaml")

    assert str(caught.value) == (
        f"{tmp_path}/world.yaml: cannot be read: No such file or directory"
    )


def test_properties_may_stand_there_with_nothing(models):
    assert models.load("properties:\nlayers: []").physics.body_count == 0


# Walls and layers

TWO_LAYERS = "properties: {}\nlayers: [{name: [ground, floor]}, {name: glass}]\n"
WALL = np.array([[2.0, -1.0, 2.0, 1.0]])
AHEAD = _core.BeamFan(0.0, 0.1, 1)


@pytest.mark.parametrize(("name", "index"), [("ground", 0), ("floor", 0), ("glass", 1)])
def test_a_layer_is_found_by_any_of_its_names(models, name, index):
    world = models.load(TWO_LAYERS)

    assert world.get_layer(name) is world.layers[index]


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        (
            TWO_LAYERS,
            "gruond",
            'no layer is named "gruond" (did you mean "ground"?); there are: ground, floor, glass',
        ),
        (EMPTY, "ground", 'no layer is named "ground"; there are: none'),
    ],
)
def test_a_layer_that_is_not_there_is_answered_by_those_that_are(models, text, name, message):
    world = models.load(text)

    for ask in (world.get_layer, lambda name: world.add_walls(name, WALL)):
        with pytest.raises(FlatlandError) as caught:
            ask(name)
        assert str(caught.value) == message


def test_walls_that_are_put_up_are_seen_and_felt_in_their_layer_alone(models, simulate):
    world = models.load(TWO_LAYERS)
    models.write("glider.yaml", BODIES.replace("density: 1", "density: 1, layers: [glass]"))
    robot = spawn(models, world, "plain.yaml", "robot", pose=Pose(1.0, 0.5, 0.0))
    glider = spawn(models, world, "glider.yaml", "glider", pose=Pose(1.0, -0.5, 0.0))
    world.add_walls("floor", WALL)
    for model in (robot, glider):
        for body in model.physics_bodies:
            body.velocity = (1.0, 0.0, 0.0)
    ground, glass = world.registry.bits(["ground", "floor"]), world.registry.bits(["glass"])

    simulate(world).run(2.0)

    assert world.physics.scan(AHEAD, (0, 0, 0), 9.0, ground)[0].tolist() == [2.0]
    assert world.physics.scan(AHEAD, (0, 0, 0), 9.0, glass)[0].tolist() == [math.inf]
    assert robot.pose.x == pytest.approx(1.9, abs=0.01)
    assert glider.pose.x == pytest.approx(3.0, abs=1e-3)


def test_walls_that_are_put_up_are_among_those_of_their_layer(models):
    world = models.load(TWO_LAYERS)
    more = np.array([[0.0, 0.0, 1.0, 1.0], [1.0, 1.0, 2.0, 0.0]])

    world.add_walls("ground", WALL)
    world.add_walls("floor", np.empty((0, 4)))
    world.add_walls("floor", more)

    assert world.get_layer("ground").segments.tolist() == [*WALL.tolist(), *more.tolist()]
    assert world.get_layer("glass").segments.tolist() == []
    assert [world.entities.owner(b.id).name for b in world.layers[0].physics_bodies] == [
        "ground",
        "ground",
    ]


@pytest.mark.parametrize(
    "segments",
    [
        pytest.param([[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, math.nan, 1.0]], id="NaN"),
        pytest.param([[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, math.inf, 1.0]], id="infinite"),
        pytest.param([[0.0, 0.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]], id="of no length"),
        pytest.param([[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 1e6, 1.0]], id="too far"),
        pytest.param([0.0, 0.0, 1.0, 1.0], id="not a list of segments"),
        pytest.param([[0.0, 0.0, 1.0]], id="three numbers"),
    ],
)
def test_walls_that_cannot_be_are_put_up_not_even_in_part(models, segments):
    world = models.load(TWO_LAYERS)

    with pytest.raises(ValueError, match="must"):
        world.add_walls("ground", np.array(segments))

    assert world.physics.body_count == 0
    assert len(world.get_layer("ground").segments) == 0


# Models without a file, failures


def test_one_configuration_makes_many_models(models, simulate, transport):
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


def test_a_model_that_cannot_be_added_leaves_the_world_as_it_was(models):
    world = models.load(EMPTY)
    good, bad = (
        ModelConfig.from_file(models.folder / name, world.registry)
        for name in ("good.yaml", "bad.yaml")
    )
    world.add_model(ModelEntry("here", "", Pose(), good))
    before = state(world)

    for entry, message in (
        (ModelEntry("here", "", Pose(), good), 'a model named "here" is already there'),
        (ModelEntry("robot", "", Pose(), bad), "no luck"),
        (ModelEntry("robot", "", Pose(1e6, 0.0, 0.0), good), "does not fit into the world"),
    ):
        with pytest.raises(FlatlandError, match=message):
            world.add_model(entry)

    assert state(world) == before


def test_a_world_knows_which_of_its_plugins_have_failed(models, simulate, monkeypatch):
    def fail(*_):
        raise ValueError("no luck")

    world = models.load(f"{EMPTY}plugins: [{{type: Herald, name: herald}}]\n")
    spawn(models, world, "good.yaml", "robot")
    assert world.plugin_failures == []
    monkeypatch.setattr(Talker, "after_physics_step", fail)
    spawn(models, world, "good.yaml", "other")

    simulate(world).run()

    [failure] = world.plugin_failures
    assert failure.label == "other/a"
    assert failure.type == "Talker"
    assert failure.reason == "after_physics_step: ValueError: no luck"
    assert world.transport.last("/population") == 2

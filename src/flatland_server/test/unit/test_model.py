"""Models: bodies, joints, names and enabled flags; where they are put, and moving them."""

import math
import subprocess
import sys
import textwrap

import pytest

from flatland_server.exceptions import FlatlandError, ModelError
from flatland_server.geometry import Pose

DISC = "footprints: [{type: circle, radius: 0.1, density: 1}]"
BASE = f"{{name: base, {DISC}}}"
WHEEL = f"{{name: wheel, pose: [1, 2, 0.5], {DISC}}}"
ENDS = "bodies: [{name: base, anchor: [1, 2]}, {name: wheel, anchor: [0, 0]}]"
WELD = f"{{type: weld, name: hub, {ENDS}}}"
WORLD = """
properties: {}
layers: [{name: floor}]
models: [{name: robot, model: robot.model.yaml, pose: [10, 20, 1.5707963267948966]}]
"""


def model(*bodies: str, joints: tuple = (), plugins: tuple = ()) -> str:
    """A model file, one entry a line: bodies from line 2 on, joints after them."""
    lines = ["bodies:", *(f"  - {body}" for body in bodies)]
    lines += ["joints:", *(f"  - {joint}" for joint in joints)]
    lines += ["plugins:", *(f"  - {plugin}" for plugin in plugins)]
    return "\n".join(lines)


def load(files, text: str):
    """The world with a robot of this model in it."""
    files.write("robot.model.yaml", text)
    return files.load(WORLD)


def refusal(files, text: str) -> str:
    """Why a model is not loaded."""
    files.write("robot.model.yaml", text)
    return files.refusal(WORLD)


def step(world, simulated_seconds: float) -> None:
    for _ in range(round(simulated_seconds / 0.005)):
        world.physics.step(0.005)


def assert_pose(actual, expected, tolerance: float = 1e-5) -> None:
    """Two poses are the same, headings modulo a whole turn."""
    assert tuple(actual)[:2] == pytest.approx(tuple(expected)[:2], abs=tolerance)
    assert math.remainder(actual[2] - expected[2], math.tau) == pytest.approx(0.0, abs=tolerance)


def test_a_body_has_the_documented_defaults(files):
    body = load(files, model(BASE)).models["robot"].base.config

    assert body.pose == (0.0, 0.0, 0.0)
    assert body.type == "dynamic"
    assert body.color == (1.0, 1.0, 1.0, 0.5)
    assert (body.linear_damping, body.angular_damping) == (0.0, 0.0)


def test_bodies_are_put_by_composing_the_models_pose_with_theirs(files):
    robot = load(files, model(BASE, WHEEL)).models["robot"]

    # The model stands at (10, 20) and is turned left by a quarter: (1, 2) of it is (-2, 1) of ours.
    assert_pose(robot.get_body("base").pose, (10, 20, math.pi / 2))
    assert_pose(robot.get_body("wheel").pose, (10 - 2, 20 + 1, math.pi / 2 + 0.5))


def test_the_models_pose_is_that_of_its_origin_not_of_its_first_body(files):
    robot = load(files, model(WHEEL, BASE)).models["robot"]

    assert_pose(robot.pose, (10, 20, math.pi / 2))


def test_a_moved_model_keeps_its_shape_and_stands_still(files):
    world = load(files, model(BASE, WHEEL))
    robot = world.models["robot"]
    robot.get_body("wheel").physics_body.velocity = (1.0, 0.0, 2.0)
    step(world, 1.0)
    bodies = [robot.get_body(name) for name in ("base", "wheel")]
    drive = bodies[0].physics_body.add_drive()
    drive.command(1.0, 0.0, 0.0)
    step(world, 0.1)
    relative = bodies[0].pose.inverse().compose(bodies[1].pose)

    world.move_model("robot", Pose(-3.0, 4.0, 3.0))
    step(world, 0.5)

    assert_pose(robot.pose, (-3, 4, 3))
    assert_pose(bodies[0].pose.inverse().compose(bodies[1].pose), relative)
    assert [body.physics_body.velocity for body in bodies] == [(0.0, 0.0, 0.0)] * 2


def test_a_model_that_cannot_be_moved_there_stays_as_it_was(files):
    world = load(files, model(BASE, f"{{name: front, pose: [5, 0, 0], {DISC}}}"))
    robot = world.models["robot"]
    poses = {name: body.pose for name, body in robot.bodies.items()}

    with pytest.raises(FlatlandError):
        world.move_model("robot", Pose(99_998.0, 0.0, 0.0))  # its front would be beyond 100 km

    assert {name: body.pose for name, body in robot.bodies.items()} == poses


@pytest.mark.parametrize(
    ("namespace", "frame", "expected"),
    [
        ("", "base", "base"),
        ("robot1", "base", "robot1_base"),
        ("robot1", "/base", "base"),
        ("", "/base", "base"),
        ("/robot1/", "base", "robot1_base"),
    ],
)
def test_a_frame_gets_the_models_namespace_unless_it_begins_with_a_slash(
    files, namespace, frame, expected
):
    files.write("robot.model.yaml", model(BASE))
    world = files.load("properties: {}\nlayers: []")

    robot = world.spawn_model(files.folder / "robot.model.yaml", "robot", namespace, Pose())

    assert robot.name_space_tf(frame) == expected


def test_what_is_not_enabled_is_as_if_it_were_not_there(files):
    text = model(
        BASE,
        "{name: wheel, enabled: false, nonsense: 1}",
        joints=("{enabled: false, type: nonsense}",),
        plugins=("{enabled: false, type: Nonsense}",),
    )

    world = load(files, text)

    assert list(world.models["robot"].bodies) == ["base"]
    assert (world.physics.body_count, world.physics.joint_count) == (1, 0)


def test_a_name_may_be_used_again_if_the_first_is_not_enabled(files):
    world = load(files, model(BASE.replace("{", "{enabled: false, ", 1), BASE))

    assert list(world.models["robot"].bodies) == ["base"]


def test_damping_slows_a_body_down_as_configured(files):
    text = model(BASE.replace("name: base", "name: base, linear_damping: 2, angular_damping: 3"))
    world = load(files, text)
    body = world.models["robot"].base.physics_body
    body.velocity = (1.0, 0.0, 1.0)

    step(world, 1.0)

    # Box2D: v <- v / (1 + damping * dt) at each step
    assert body.velocity == pytest.approx((1.01**-200, 0.0, 1.015**-200), rel=1e-3, abs=1e-6)


def test_a_weld_snaps_its_anchors_together_and_holds_its_angle(files):
    joint = WELD.replace("type: weld", "type: weld, angle: 0.3")
    world = load(files, model(BASE, f"{{name: wheel, {DISC}}}", joints=(joint,)))
    robot = world.models["robot"]

    step(world, 1.0)

    relative = robot.get_body("base").pose.inverse().compose(robot.get_body("wheel").pose)
    assert_pose(relative, (1, 2, 0.3), tolerance=0.01)


def test_a_revolute_joint_turns_freely_within_its_limits(files):
    joint = WELD.replace("type: weld", "type: revolute, limits: [-0.5, 1.0]")
    wheel = WHEEL.replace("0.5]", "0]", 1)
    world = load(files, model(BASE.replace("base,", "base, type: static,"), wheel, joints=(joint,)))
    robot = world.models["robot"]
    wheel_body = robot.get_body("wheel").physics_body

    for push, stop in ((1.0, 1.0), (-1.0, -0.5)):
        for _ in range(400):
            wheel_body.apply_torque(0.001 * push)
            world.physics.step(0.005)
        assert robot.joints[0].physics_joint.angle == pytest.approx(stop, abs=0.05)


@pytest.mark.parametrize(("collide", "turned"), [("false", 3.0), ("true", None)])
def test_jointed_bodies_touch_each_other_only_if_asked_to(files, collide, turned):
    # An arm turns about a hinge at the origin, towards a post that stands at a quarter turn.
    arm = "[[0.2, -0.02], [0.8, -0.02], [0.8, 0.02], [0.2, 0.02]]"
    text = model(
        "{name: base, type: static, footprints: "
        "[{type: circle, center: [0, 0.5], radius: 0.1, density: 1}]}",
        f"{{name: wheel, footprints: [{{type: polygon, points: {arm}, density: 1}}]}}",
        joints=(
            f"{{type: revolute, name: hinge, collide_connected: {collide}, "
            "bodies: [{name: base, anchor: [0, 0]}, {name: wheel, anchor: [0, 0]}]}",
        ),
    )
    world = load(files, text)
    robot = world.models["robot"]
    robot.get_body("wheel").physics_body.velocity = (0.0, 0.0, 1.0)

    step(world, 3.0)

    angle = robot.joints[0].physics_joint.angle
    if turned is None:
        assert angle < math.pi / 2 - 0.1
    else:
        assert angle == pytest.approx(turned, abs=0.02)


def test_getting_a_body_that_is_not_there_names_those_that_are(files):
    robot = load(files, model(BASE, WHEEL)).models["robot"]

    with pytest.raises(ModelError) as caught:
        robot.get_body("whele")

    message = 'the model has no body "whele" (did you mean "wheel"?); it has: base, wheel'
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        pytest.param(
            "bodies: []",
            "1: bodies: expected at least one body, found none",
            id="no body",
        ),
        pytest.param("joints: []", '1: the required key "bodies" is missing', id="bodies missing"),
        pytest.param(
            model(BASE.replace("{", "{enabled: false, ", 1)),
            "2: bodies: expected at least one body, found none",
            id="no body enabled",
        ),
        pytest.param(
            model(BASE, BASE),
            '3: bodies[1].name: the name "base" is given twice',
            id="two bodies of one name",
        ),
        pytest.param(
            model(BASE, WHEEL, joints=(WELD, WELD)),
            '6: joints[1].name: the name "hub" is given twice',
            id="two joints of one name",
        ),
        pytest.param(
            model(BASE, plugins=("{type: Laser, name: a}", "{type: Laser, name: a}")),
            '6: plugins[1].name: the name "a" is given twice',
            id="two plugins of one name",
        ),
        pytest.param(
            model(BASE.replace("name: base", "name: base, typ: static"), WHEEL),
            '2: bodies[0] "base": unknown key "typ" (did you mean "type"?)',
            id="unknown key of a body",
        ),
        pytest.param(
            model(BASE.replace("name: base", "name: base, type: dynamo"), WHEEL),
            "2: bodies[0].type: expected static, kinematic or dynamic "
            '(did you mean "dynamic"?), found "dynamo"',
            id="unknown type of body",
        ),
        pytest.param(
            model("{name: base}", WHEEL),
            '2: bodies[0] "base": the required key "footprints" is missing',
            id="footprints missing",
        ),
        pytest.param(
            model(BASE.replace("name: base", "name: base, linear_damping: -1"), WHEEL),
            "2: bodies[0].linear_damping: expected a number of 0 or more, found -1",
            id="negative damping",
        ),
        pytest.param(
            model(BASE, WHEEL, joints=(WELD.replace("name: wheel", "name: weel"),)),
            '5: joints[0].bodies[1].name: the model has no body "weel" (did you mean "wheel"?)',
            id="a joint's body is not there",
        ),
        pytest.param(
            model(BASE, WHEEL.replace("{", "{enabled: false, ", 1), joints=(WELD,)),
            '5: joints[0].bodies[1].name: the model has no body "wheel"',
            id="a joint's body is not enabled",
        ),
        pytest.param(
            model(BASE, WHEEL, joints=(WELD.replace("wheel", "base"),)),
            '5: joints[0].bodies: expected two bodies, found "base" twice',
            id="a joint of a body with itself",
        ),
        pytest.param(
            model(BASE, joints=("{type: weld, name: a, bodies: [{name: base, anchor: [0, 0]}]}",)),
            "4: joints[0].bodies: expected two bodies, found 1",
            id="a joint of one body",
        ),
        pytest.param(
            model(BASE, WHEEL, joints=(WELD.replace("weld", "hinge"),)),
            '5: joints[0].type: expected revolute or weld, found "hinge"',
            id="unknown type of joint",
        ),
        pytest.param(
            model(BASE, WHEEL, joints=(WELD.replace("weld", "revolute, limits: [1, -1]"),)),
            "5: joints[0].limits: expected [lower, upper], found 1 above -1",
            id="limits the wrong way round",
        ),
        pytest.param(
            model(BASE, WHEEL, joints=(WELD.replace("weld", "weld, limits: [0, 1]"),)),
            '5: joints[0] "hub": unknown key "limits"',
            id="limits of a weld",
        ),
        pytest.param(
            model(BASE, WHEEL, joints=(WELD.replace(", anchor: [1, 2]", ""),)),
            '5: joints[0].bodies[0] "base": the required key "anchor" is missing',
            id="anchor missing",
        ),
        pytest.param(
            model(BASE, plugins=("{name: laser}",)),
            '5: plugins[0] "laser": the required key "type" is missing',
            id="a plugin's type is missing",
        ),
        pytest.param(
            model(BASE, plugins=("{type: Laser}",)),
            '5: plugins[0]: the required key "name" is missing',
            id="a plugin's name is missing",
        ),
        pytest.param(
            model(BASE) + "\nplugin: []\n",
            '5: unknown key "plugin"',
            id="unknown key of a model",
        ),
    ],
)
def test_a_wrong_model_is_refused_at_its_line(files, text, message):
    assert refusal(files, text) == f"robot.model.yaml:{message}"


def test_one_thing_wrong_in_the_only_body_is_one_line(files):
    message = refusal(files, model(BASE.replace("name: base", "name: base, typ: static")))

    assert len(message.splitlines()) == 1


@pytest.mark.parametrize("key", ["linear_damping", "angular_damping"])
def test_a_damping_beyond_single_precision_does_not_end_the_process(files, key):
    files.write("robot.model.yaml", model(BASE.replace("name: base", f"name: base, {key}: 1e39")))
    path = files.write("world.yaml", WORLD)
    program = """
        import sys
        from pathlib import Path
        from flatland_server.exceptions import FlatlandError
        from flatland_server.simulation.world import World
        try:
            World.from_file(Path(sys.argv[1]))
        except FlatlandError:
            print("refused")
    """

    result = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program), str(path)], stdout=subprocess.PIPE
    )

    assert (result.returncode, result.stdout) == (0, b"refused\n")


def test_friction_beyond_single_precision_does_not_reach_box2d(files):
    rough = BASE.replace("density: 1", "density: 1, friction: 1e39")
    files.write("robot.model.yaml", model(rough))

    assert files.refusal(WORLD).startswith("robot.model.yaml:2: bodies[0].footprints[0]")

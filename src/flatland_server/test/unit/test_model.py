"""Models: poses of bodies, moving, frames, and parts that are not enabled."""

import math

import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose

DISC = "footprints: [{type: circle, radius: 0.1, density: 1}]"
BASE = f"{{name: base, {DISC}}}"
WHEEL = f"{{name: wheel, pose: [1, 2, 0.5], {DISC}}}"
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


def step(world, simulated_seconds: float) -> None:
    for _ in range(round(simulated_seconds / 0.005)):
        world.physics.step(0.005)


def assert_pose(actual, expected, tolerance: float = 1e-5) -> None:
    """Asserts that two poses are the same, headings modulo a whole revolution."""
    assert tuple(actual)[:2] == pytest.approx(tuple(expected)[:2], abs=tolerance)
    assert math.remainder(actual[2] - expected[2], math.tau) == pytest.approx(0.0, abs=tolerance)


def test_a_body_pose_is_relative_to_the_pose_of_its_model(files):
    robot = load(files, model(BASE, WHEEL)).models["robot"]

    # The model is at (10, 20), rotated by a quarter turn: (1, 2) in it is (-2, 1) in the world.
    assert_pose(robot.get_body("base").pose, (10, 20, math.pi / 2))
    assert_pose(robot.get_body("wheel").pose, (10 - 2, 20 + 1, math.pi / 2 + 0.5))


def test_the_pose_of_a_model_is_that_of_its_origin(files):
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
    assert robot.move_revision == 1


def test_a_model_that_cannot_be_moved_stays_where_it_was(files):
    world = load(files, model(BASE, f"{{name: front, pose: [5, 0, 0], {DISC}}}"))
    robot = world.models["robot"]
    poses = {name: body.pose for name, body in robot.bodies.items()}

    with pytest.raises(FlatlandError):
        world.move_model("robot", Pose(99_998.0, 0.0, 0.0))  # its front would be beyond 100 km

    assert {name: body.pose for name, body in robot.bodies.items()} == poses
    assert robot.move_revision == 0


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
def test_a_frame_without_a_leading_slash_gets_the_namespace(files, namespace, frame, expected):
    files.write("robot.model.yaml", model(BASE))
    world = files.load("properties: {}\nlayers: []")

    robot = world.spawn_model(files.folder / "robot.model.yaml", "robot", namespace, Pose())

    assert robot.name_space_tf(frame) == expected


def test_parts_that_are_not_enabled_are_left_out(files):
    text = model(
        BASE,
        "{name: wheel, enabled: false, nonsense: 1}",
        joints=("{enabled: false, type: nonsense}",),
        plugins=("{enabled: false, type: Nonsense}",),
    )

    world = load(files, text)

    assert list(world.models["robot"].bodies) == ["base"]
    assert (world.physics.body_count, world.physics.joint_count) == (1, 0)


def test_damping_slows_a_body_down_as_configured(files):
    text = model(BASE.replace("name: base", "name: base, linear_damping: 2, angular_damping: 3"))
    world = load(files, text)
    body = world.models["robot"].base.physics_body
    body.velocity = (1.0, 0.0, 1.0)

    step(world, 1.0)

    # Box2D: v <- v / (1 + damping * dt) at each step
    assert body.velocity == pytest.approx((1.01**-200, 0.0, 1.015**-200), rel=1e-3, abs=1e-6)

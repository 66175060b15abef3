"""Joints of models: limits, anchors, stiffness, and collisions of joined bodies."""

import math
from typing import Tuple

import pytest
from geometry_msgs.msg import Twist

from flatland_server.geometry import Pose
from flatland_server.simulation.run import Run
from flatland_server.timekeeper import Timekeeper

SQUARE = "{type: polygon, points: [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]], density: 1}"

ARM = "{type: polygon, points: [[0, -0.05], [1, -0.05], [1, 0.05], [0, 0.05]], density: 1}"


def hinged(options: str = "", arm_pose: str = "[0, 0, 0]") -> str:
    """A model file of an arm, joined by its origin to a wall at (1, 0) in the wall's frame."""
    return f"""
        bodies:
          - name: wall
            type: static
            footprints: [{SQUARE}]
          - name: arm
            pose: {arm_pose}
            footprints: [{ARM}]
        joints:
          - type: revolute
            name: hinge
            {options}
            bodies:
              - {{name: wall, anchor: [1, 0]}}
              - {{name: arm, anchor: [0, 0]}}
        """


def towing(weld: str = "", trailer_density: float = 1.0) -> str:
    """A model file of a robot, to which two wheels and a trailer are welded."""
    ends = {
        "left": ([0, 0.3], [0, 0]),
        "right": ([0, -0.3], [0, 0]),
        "trailer": ([-0.9, 0], [0.4, 0]),
    }
    joints = "".join(
        f"\n          - {{type: weld, name: {name}_weld, {weld} bodies: "
        f"[{{name: base, anchor: {on_base}}}, {{name: {name}, anchor: {on_other}}}]}}"
        for name, (on_base, on_other) in ends.items()
    )
    wheel = "{type: polygon, points: [[-.1, -.03], [.1, -.03], [.1, .03], [-.1, .03]], density: 1}"
    return f"""
        bodies:
          - name: base
            footprints: [{{type: circle, radius: 0.4, density: 1}}]
          - {{name: left, pose: [0, 0.3, 0], footprints: [{wheel}]}}
          - {{name: right, pose: [0, -0.3, 0], footprints: [{wheel}]}}
          - name: trailer
            pose: [-1.3, 0, 0]
            footprints: [{{type: circle, radius: 0.4, density: {trailer_density}}}]
        joints:{joints}
        plugins:
          - {{type: DiffDrive, name: drive, body: base}}
        """


def joint_angle(model, joint: str = "hinge") -> float:
    return next(j for j in model.joints if j.name == joint).physics_joint.angle


def total_turn(world, seconds: float, torque: float) -> float:
    """The angle [rad] by which the arm turns under a torque, with whole revolutions."""
    robot = world.get_model("robot")
    arm = robot.get_body("arm").physics_body
    before, total = joint_angle(robot), [0.0]

    def push() -> None:
        nonlocal before
        now = joint_angle(robot)
        total[0] += math.remainder(now - before, math.tau)
        before = now
        arm.apply_torque(torque)

    step(world, seconds, push)
    return total[0]


def step(world, seconds: float, push=lambda: None) -> None:
    run = Run(world, Timekeeper(0.005))
    for _ in range(round(seconds / 0.005)):
        push()
        run.step()


def command(world, vx: float, omega: float) -> None:
    twist = Twist()
    twist.linear.x, twist.angular.z = vx, omega
    world.transport.send("/cmd_vel", twist)


def drive_with_turns(world, watch) -> None:
    """Drives for 10 s with turns to both sides and on the spot; calls `watch` after each step."""
    run = Run(world, Timekeeper(0.005))
    for vx, omega in [(1.0, 0.0), (1.0, 1.0), (0.8, -2.0), (-1.0, 0.5), (0.0, 3.0)]:
        command(world, vx, omega)
        for _ in range(400):
            run.step()
            watch()


def deviation(model, body: str, expected: Pose) -> Tuple[float, float]:
    """The deviation of a body from its place relative to the base: metres, degrees."""
    actual = model.base.pose.inverse().compose(model.get_body(body).pose)
    off = expected.inverse().compose(actual)
    return math.hypot(off.x, off.y), abs(math.degrees(off.yaw))


def worst_deviation(world) -> Tuple[float, float]:
    """The greatest deviation of wheels and trailer in a drive with turns."""
    robot = world.get_model("robot")
    places = {
        name: robot.base.pose.inverse().compose(robot.get_body(name).pose)
        for name in ("left", "right", "trailer")
    }
    worst = [(0.0, 0.0)]
    drive_with_turns(
        world, lambda: worst.extend(deviation(robot, name, at) for name, at in places.items())
    )
    return max(far for far, _ in worst), max(turned for _, turned in worst)


# Hinges


@pytest.mark.parametrize(
    ("lower", "upper", "torque"),
    [*((-0.5, 0.25, torque) for torque in (0.5, -0.5, 5.0, -5.0)), (0.0, 0.0, 0.5)],
)
def test_a_hinge_stops_at_its_limits_under_torque(files, lower, upper, torque):
    world = files.spawn(hinged(f"limits: [{lower}, {upper}]"))
    robot = world.get_model("robot")
    arm = robot.get_body("arm").physics_body
    angles = []

    step(world, 3.0, lambda: (arm.apply_torque(torque), angles.append(joint_angle(robot))))

    # Box2D lets a limit give by 2 degrees (b2_angularSlop) and pushes back what is beyond.
    slop = math.radians(2)
    assert lower - slop <= min(angles)
    assert max(angles) <= upper + slop
    assert joint_angle(robot) == pytest.approx(upper if torque > 0 else lower, abs=slop)


def test_a_hinge_without_limits_turns_by_whole_revolutions(files):
    world = files.spawn(hinged())

    assert total_turn(world, 5.0, 0.5) > math.tau

    arm = world.get_model("robot").get_body("arm").pose
    assert (arm.x, arm.y) == pytest.approx((1.0, 0.0), abs=0.01)


def test_limits_are_relative_to_equal_headings_of_the_bodies(files):
    world = files.spawn(hinged("limits: [-0.5, 0.5]", arm_pose="[1, 0, 2.0]"))

    step(world, 3.0)

    assert joint_angle(world.get_model("robot")) <= 0.5 + math.radians(2.1)


# Anchors


@pytest.mark.parametrize("arm_pose", ["[0, 0, 0]", "[1.3, 0.2, 0.4]", "[-2, 3, 0]"])
def test_a_hinge_snaps_its_anchors_together(files, arm_pose):
    world = files.spawn(hinged(arm_pose=arm_pose))

    step(world, 3.0)

    arm = world.get_model("robot").get_body("arm").pose
    assert (arm.x, arm.y) == pytest.approx((1.0, 0.0), abs=0.006)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_weld_snaps_its_anchors_together_at_its_angle(files, angle):
    text = hinged(f"angle: {angle}", arm_pose="[0, 0, 1]").replace("revolute", "weld")
    world = files.spawn(text)

    step(world, 3.0)

    arm = world.get_model("robot").get_body("arm").pose
    assert tuple(arm) == pytest.approx((1.0, 0.0, angle), abs=0.02)


# Welds


@pytest.mark.parametrize("trailer_density", [1.0, 10.0], ids=["light trailer", "heavy trailer"])
def test_a_rigid_weld_holds_a_millimetre_and_a_tenth_of_a_degree(files, trailer_density):
    world = files.spawn(towing(trailer_density=trailer_density))

    far, turned = worst_deviation(world)

    assert far < 0.001
    assert turned < 0.1


def test_a_robot_with_a_trailer_drives_as_commanded(files):
    world = files.spawn(towing(trailer_density=10))
    command(world, 1.0, 0.0)

    step(world, 2.0)

    assert tuple(world.get_model("robot").pose) == pytest.approx((2.0, 0.0, 0.0), abs=0.1)


def test_a_soft_weld_gives_way_and_a_rigid_one_does_not(files):
    _, rigid = worst_deviation(files.spawn(towing(trailer_density=10)))
    _, soft = worst_deviation(files.spawn(towing("frequency: 2, damping: 0.1,", 10)))

    assert soft > 1.0
    assert soft > 10 * rigid


def test_a_soft_weld_returns_to_its_angle(files):
    text = hinged("frequency: 2\n            damping: 0.7", arm_pose="[1, 0, 0]")
    world = files.spawn(text.replace("revolute", "weld"))
    robot = world.get_model("robot")
    arm = robot.get_body("arm").physics_body
    step(world, 0.5, lambda: arm.apply_torque(1.0))
    bent = abs(joint_angle(robot))

    step(world, 3.0)

    assert bent > 0.02
    assert abs(joint_angle(robot)) < bent / 20


# Collisions of joined bodies


@pytest.mark.parametrize(("collide", "is_stopped"), [("false", False), ("true", True), ("", False)])
def test_joined_bodies_collide_only_if_asked_to(files, collide, is_stopped):
    option = f"collide_connected: {collide}" if collide else ""
    # The wall has a post in the path of the arm, after a quarter turn.
    text = hinged(option, arm_pose="[1, 0, 0]").replace(
        f"footprints: [{SQUARE}]",
        "footprints: [{type: circle, center: [1, 0.8], radius: 0.1, density: 1}]",
    )
    world = files.spawn(text)

    assert (total_turn(world, 3.0, 0.2) < math.pi / 2) is is_stopped


@pytest.mark.parametrize("kind", ["revolute", "weld"])
def test_a_joint_that_is_not_enabled_has_no_effect(files, kind):
    world = files.spawn(hinged("enabled: false", arm_pose="[1, 0, 0]").replace("revolute", kind))
    robot = world.get_model("robot")
    robot.get_body("arm").physics_body.velocity = (1.0, 0.0, 0.0)

    step(world, 1.0)

    assert robot.joints == []
    assert robot.get_body("arm").pose.x == pytest.approx(2.0, abs=0.01)


def test_moving_a_model_keeps_its_joints(files):
    world = files.spawn(towing())
    robot = world.get_model("robot")

    world.move_model("robot", Pose(5, 6, 1.5))
    step(world, 1.0)

    assert tuple(robot.pose) == pytest.approx((5, 6, 1.5), abs=1e-3)
    assert deviation(robot, "trailer", Pose(-1.3, 0, 0))[0] < 0.001

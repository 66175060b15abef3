"""Tween: the pose of a body at each time, in every mode and with every easing."""

from typing import Any, Tuple

import numpy as np
import pytest
from std_msgs.msg import Bool

TWEEN = "type: Tween, name: tween, body: base"
UNIT = f"{TWEEN}, delta: [1, 0, 0]"
TRIGGER = f"{UNIT}, mode: trigger"
DOCUMENTED = (
    f"{TWEEN}, mode: yoyo, easing: cubicInOut, trigger_topic: tween_trigger, duration: 10, "
    "delta: [2, 3, 1.1]"
)


def in_box2d(*pose: float) -> Tuple[float, ...]:
    """A pose rounded to Box2D's single precision."""
    return tuple(float(np.float32(value)) for value in pose)


def position(simulation: Any) -> Tuple[float, ...]:
    """The pose of the robot's body in Box2D, whole revolutions included."""
    return tuple(simulation.model().base.physics_body.pose)


def trigger(simulation: Any, forward: bool, topic: str = "/tween_trigger") -> None:
    simulation.transport.send(topic, Bool(forward))


@pytest.mark.parametrize(
    ("keys", "ways"),
    [
        ("", [0.5, 1.0, 0.5, 0.0, 0.5]),  # yoyo, linear and one second
        (", mode: yoyo", [0.5, 1.0, 0.5, 0.0, 0.5]),
        (", mode: once", [0.5, 1.0, 1.0, 1.0, 1.0]),
        (", mode: loop", [0.5, 1.0, 0.5, 1.0, 0.5]),
        (", mode: trigger", [0.0, 0.0, 0.0, 0.0, 0.0]),
        (", easing: quadraticIn", [0.25, 1.0]),
        (", easing: backOut", [1 - 2.70158 * 0.5**3 + 1.70158 * 0.5**2, 1.0]),
    ],
)
def test_each_mode_and_easing_goes_its_way(files, keys, ways):
    robot = files.robot(f"{UNIT}{keys}, trigger_topic: open")

    assert [position(robot.run(0.5))[0] for _ in ways] == pytest.approx(ways, abs=1e-6)
    assert robot.transport.subscribed == ({"/open"} if "trigger" in keys else set())


def test_a_trigger_opens_turns_round_and_closes(files):
    robot = files.robot(f"{TRIGGER}, trigger_topic: open")

    ways = []
    for forward in (True, False, True, True, False, False):
        trigger(robot, forward, "/open")
        ways.append(position(robot.run(0.5))[0])

    assert ways == pytest.approx([0.5, 0.0, 0.5, 1.0, 0.5, 0.0], abs=1e-6)


@pytest.mark.parametrize("heading", [0.5, 2.5])
def test_the_documentations_example(files, heading):
    robot = files.robot(DOCUMENTED, pose=f"[10, -20, {heading}]")

    robot.run(5.0)
    halfway = position(robot)
    robot.run(5.0)
    end = position(robot)
    robot.run(10.0)

    assert halfway == pytest.approx((11.0, -18.5, heading + 0.55), abs=1e-6)
    assert end == in_box2d(12.0, -17.0, heading + 1.1)
    assert position(robot) == in_box2d(10.0, -20.0, heading)


@pytest.mark.parametrize("body_type", ["static", "kinematic", "dynamic"])
@pytest.mark.parametrize("mode", ["yoyo", "once", "loop"])
def test_bodies_are_moved_and_go_on_from_where_they_are_put(files, body_type, mode):
    tween = f"{TWEEN}, mode: {mode}, delta: [2, 3, 1.1]"
    model = files.model("door", tween, body=f"type: {body_type},")
    world = files.load_models({"robot": f"model: {model}, pose: [1, 1, 1]"})

    assert position(world.run(0.25)) == pytest.approx((1.5, 1.75, 1.275), abs=1e-6)
    world.world.move_model("robot", world.model().pose._replace(x=-5.0, y=7.0, yaw=2.0))
    assert position(world) == in_box2d(-5.0, 7.0, 2.0)
    assert position(world.run(0.75)) == pytest.approx((-3.5, 9.25, 2.825), abs=1e-6)


def test_only_the_named_body_is_moved(files):
    bodies = "[{name: post, footprints: []}, {name: wing, pose: [0, 1, 0], footprints: []}]"
    tween = "{type: Tween, name: tween, body: wing, mode: once, delta: [2, 0, 0]}"
    files.write("gate.yaml", f"bodies: {bodies}\nplugins: [{tween}]")
    gate = files.load_models({"gate": "model: gate.yaml, pose: [5, 5, 3.14159]"}).run(2.0)

    bodies = gate.model("gate").bodies
    assert bodies["post"].pose == pytest.approx((5.0, 5.0, 3.14159), abs=1e-6)
    # The delta is in the world's frame, though the model is turned.
    assert bodies["wing"].pose == pytest.approx((7.0, 4.0, 3.14159), abs=1e-5)


def test_its_velocity_is_that_of_the_movement(files):
    robot = files.robot(f"{TWEEN}, duration: 2, easing: quadraticIn, delta: [1, -2, 3]").run(1.0)

    # d/dt (t / 2)^2 = t / 2, in the middle of the last step
    rate = 0.9975 / 2
    velocity = robot.model().base.physics_body.velocity
    assert velocity == pytest.approx((rate, -2 * rate, 3 * rate), abs=1e-4)


def test_a_body_in_its_way_is_pushed_and_does_not_hold_it_up(files):
    parcel = files.model("parcel", body="linear_damping: 4,")
    wall = f"name: walls, map: {files.walls('wall', '1.1 -3 1.1 3')}"
    entry = f"model: {parcel}, pose: [0.5, 0, 0]"
    robot = files.robot(f"{UNIT}, mode: once", others={"parcel": entry}, layers=(wall,))

    robot.run(0.25)
    assert robot.model("parcel").pose.x == pytest.approx(0.25 + 0.4, abs=0.02)
    robot.run(0.25)
    assert robot.model("parcel").pose.x == pytest.approx(0.9, abs=0.02)

    # From here on there is no room for both.
    robot.run(0.3)
    assert position(robot) == in_box2d(0.8, 0.0, 0.0)

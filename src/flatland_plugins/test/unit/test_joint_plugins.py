"""JointMotor and JointStatePublisher: an arm that turns about a pillar."""

import math
from typing import Any

import pytest
from logged import warnings

from flatland2d import PluginError, Simulation, SimulationBatch
from flatland_server import messages
from flatland_server.exceptions import FlatlandError

Float64 = messages.get("std_msgs/Float64")

MODEL = """
bodies:
  - {name: pillar, type: static, footprints: [{type: circle, radius: 0.1, density: 1, layers: []}]}
  - {name: arm, footprints: [{type: polygon, density: 10,
     points: [[0, -0.05], [1, -0.05], [1, 0.05], [0, 0.05]]}]}
  - {name: tip, pose: [1, 0, 0], footprints: [{type: circle, radius: 0.02, density: 1, layers: []}]}
joints:
  - {type: revolute, name: elbow, LIMITS bodies: [{name: pillar, anchor: [0, 0]},
     {name: arm, anchor: [0, 0]}]}
  - {type: weld, name: glue, bodies: [{name: arm, anchor: [1, 0]}, {name: tip, anchor: [0, 0]}]}
plugins:
  - {type: JointStatePublisher, name: states}
  - {type: JointMotor, name: motor, KEYS}
"""
TORQUE = "joint: elbow, max_torque: 20"


def arm(files: Any, keys: str = TORQUE, limits: str = "", **options: Any) -> Any:
    text = MODEL.lstrip("\n").replace("KEYS", keys)
    files.write("arm.model.yaml", text.replace("LIMITS", limits))
    return files.load_models({"robot": "model: arm.model.yaml"}, **options)


def command(robot: Any, value: float) -> Any:
    robot.transport.send("/motor/command", Float64(value))
    return robot


def angle_of(robot: Any) -> float:
    return robot.model().get_joint("elbow").physics_joint.angle


def test_it_turns_at_a_velocity(files):
    robot = command(arm(files), 0.5).run(2.0)
    assert angle_of(robot) == pytest.approx(1.0, abs=1e-2)

    command(robot, 0.0).run(1.0)
    before = angle_of(robot)
    robot.run(1.0)
    assert angle_of(robot) == pytest.approx(before, abs=1e-4)


@pytest.mark.parametrize(
    ("limits", "target", "reached"),
    [
        ("", 1.2, 1.2),
        ("", 4.0, 4.0 - math.tau),
        ("limits: [-1, 1],", 2.0, 1.0),
        ("limits: [-0.5, 4],", 3.6, 3.6 - math.tau),
    ],
)
def test_it_turns_to_a_position_and_stays_there(files, limits, target, reached):
    robot = command(arm(files, f"{TORQUE}, mode: position, max_velocity: 2", limits), target)
    robot.run(1.0)
    assert abs(robot.model().get_joint("elbow").physics_joint.speed) < 2.0 + 1e-3
    robot.run(2.0)

    robot.model().get_body("arm").physics_body.apply_angular_impulse(0.05)
    robot.run(1.0)

    assert angle_of(robot) == pytest.approx(reached, abs=1e-2)


def test_its_torque_is_limited(files):
    robot = command(arm(files, "joint: elbow, max_torque: 0.5"), 100.0).run(1.0)

    hinge = robot.model().get_joint("elbow").physics_joint
    arm_body, tip = (robot.model().get_body(name).physics_body for name in ("arm", "tip"))
    inertia = arm_body.inertia + arm_body.mass * 0.25 + tip.inertia + tip.mass
    assert hinge.speed == pytest.approx(0.5 / inertia, rel=1e-2)


@pytest.mark.parametrize("mode", ["velocity", "position"])
def test_wrong_commands_are_ignored_with_a_warning(files, caplog, mode):
    robot = command(arm(files, f"{TORQUE}, mode: {mode}"), 0.5).run(1.0)
    before = robot.model().get_joint("elbow").physics_joint.motor
    for wrong in (math.nan, math.inf, -1e300):
        command(robot, wrong).run(0.1)

    assert len(warnings(caplog)) == 3
    assert "motor/command: expected a finite number, found nan" in warnings(caplog)[0]
    if mode == "velocity":
        assert robot.model().get_joint("elbow").physics_joint.motor == before


def test_the_states_are_those_of_the_joints(files):
    robot = command(arm(files), 0.5).run(1.0)

    message = robot.last("/joint_states")

    hinge = robot.model().get_joint("elbow").physics_joint
    found = message.name, message.position, message.velocity, message.effort
    expected = ["elbow"], [hinge.angle], [hinge.speed], [hinge.motor_torque]
    assert tuple(map(list, found)) == expected
    assert message.velocity[0] == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("joint: glue, max_torque: 1", "expected a revolute joint, found a weld"),
        ("joint: elbo, max_torque: 1", 'no joint "elbo" (did you mean "elbow"?)'),
        ("joint: elbow, max_torque: 0", "expected a number above 0, found 0"),
        (f"{TORQUE}, mode: speed", 'expected velocity or position, found "speed"'),
        (f"{TORQUE}}}\n  - {{type: JointStatePublisher, name: s, joints: [glue]", '"glue", a weld'),
    ],
)
def test_wrong_keys_are_refused(files, keys, message):
    with pytest.raises(FlatlandError) as caught:
        arm(files, keys)

    assert message in str(caught.value)


def test_states_keep_target_positions_and_batches_refuse_them(files):
    arm(files, f"{TORQUE}, mode: position, max_velocity: 1").world.close()
    world = files.folder / "world.yaml"
    with Simulation(world) as simulation, Simulation(world) as other:
        simulation.publish("motor/command", Float64(1.5))
        simulation.step(40)
        other.load_state(simulation.save_state())
        for each in (simulation, other):
            each.step(1000)
            hinge = each.models["robot"].model.get_joint("elbow").physics_joint
            assert hinge.angle == pytest.approx(1.5, abs=1e-3)
            assert each.models["robot"].sensors["states"].read().name == ("elbow",)
        assert simulation.save_state() == other.save_state()
    with pytest.raises(PluginError, match="motor"):
        SimulationBatch(world, 2)

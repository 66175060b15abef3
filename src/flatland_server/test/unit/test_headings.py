"""Joints at headings near 180 degrees, where angles wrap: no constraint error arises."""

import math

import pytest

from flatland_server.geometry import Pose, wrap_angle
from flatland_server.simulation.run import Run
from flatland_server.timekeeper import Timekeeper

MODEL = """
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.2, density: 10}]}
  - {name: arm, pose: [0.5, 0, 0.5], footprints: [{type: circle, radius: 0.2, density: 10}]}
joints:
  - type: JOINT
    name: shoulder
    bodies: [{name: base, anchor: [0.5, 0]}, {name: arm, anchor: [0, 0]}]
"""
WELD = MODEL.replace("JOINT", "weld\n    angle: 0.5")
HINGE = MODEL.replace("JOINT", "revolute\n    limits: [0.4, 0.6]")


@pytest.mark.parametrize("model", [WELD, HINGE], ids=["weld", "hinge"])
@pytest.mark.parametrize("heading", [0.0, 3.0, math.pi, -math.pi, -3.0, 100.0])
@pytest.mark.parametrize("way", ["spawned", "moved", "moved back"])
def test_jointed_bodies_stay_where_they_are_put(files, model, heading, way):
    files.write("robot.model.yaml", model)
    at = heading if way == "spawned" else 0.0
    world = files.load(
        f"properties: {{}}\nlayers: []\n"
        f"models: [{{name: robot, pose: [1, 2, {at}], model: robot.model.yaml}}]\n"
    )
    robot = world.models["robot"]
    if way != "spawned":
        world.move_model("robot", Pose(1.0, 2.0, heading))
    if way == "moved back":
        world.move_model("robot", Pose(1.0, 2.0, 0.0))
        heading = 0.0

    Run(world, Timekeeper(0.005)).step(200)

    assert robot.pose[:2] == pytest.approx((1.0, 2.0), abs=1e-3)
    assert wrap_angle(robot.pose.yaw - heading) == pytest.approx(0.0, abs=1e-3)
    arm = robot.bodies["arm"].pose
    assert wrap_angle(arm.yaw - heading - 0.5) == pytest.approx(0.0, abs=1e-3)

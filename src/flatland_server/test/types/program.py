# pyright: strict, reportUnknownMemberType=false, reportUninitializedInstanceVariable=false
"""A user's program, for scripts/check: type checkers find the types that are asserted here."""

from typing import Any

import numpy as np
from typing_extensions import assert_type

from flatland2d import (
    BatchObservation,
    ModelHandle,
    Pose,
    SensorHandle,
    Simulation,
    SimulationBatch,
    Touch,
    Velocity,
    messages,
)
from flatland2d.sweep import SweepRun
from flatland_server import BoolArray, Float32Array, FloatArray

World = dict[str, Any]


def drive(world: World) -> float:
    """Drives, and reads all that there is to read."""
    with Simulation(world, seed=1, topics=["/scan"]) as sim:
        assert_type(sim, Simulation)
        robot = sim.models["robot"]
        assert_type(robot, ModelHandle)
        robot.command(0.5, 0.2)
        assert_type(sim.step(20), Simulation)
        laser: SensorHandle[Float32Array] = robot.sensors["laser"]
        assert_type(laser.read(), Float32Array)
        assert_type(laser.read("intensities"), Any)
        assert_type(robot.sensors["imu"].read(), Any)
        assert_type(robot.pose, Pose)
        assert_type(robot.pose.x, float)
        assert_type(robot.local_velocity, Velocity)
        assert_type(sim.poses, FloatArray)
        assert_type(sim.contacts, list[Touch])
        assert_type(sim.last("/scan"), Any)
        assert_type(sim.topics, dict[str, str])
        assert_type(sim.save_state(), bytes)
        twist = messages.get("geometry_msgs/Twist")()
        twist.linear.x = 0.5
        sim.publish("/cmd_vel", twist)
        place(sim)
        with sim.record("run.bag", topics=["/scan"]):
            sim.step()
        return float(laser.read().min())


def place(sim: Simulation) -> None:
    """Puts models at poses of all kinds."""
    sim.spawn({"bodies": [{"name": "base"}]}, "box", Pose(1.0, 2.0))
    sim.spawn("box.model.yaml", "other", [1, 2, 0.5])
    sim.move("box", (1.0, 2.0, 0.0))
    sim.move("box", np.array([1.0, 2.0, 0.0]))
    sim.move("box", np.zeros(3, np.float32))
    sim.move("box", sim.poses[0])
    sim.world.move_model("box", np.array([1, 2, 0]))
    body = sim.models["box"].model.base.physics_body
    body.velocity = (1.0, 0.0, 0.0)
    body.velocity = np.array([1.0, 0.0, 0.0])
    body.apply_force([1.0, 0.0])


def step_many(world: World) -> BoolArray:
    """Steps a batch."""
    with SimulationBatch(world, 8, threads=2) as batch:
        observation = batch.step(np.zeros((8, 2)), substeps=20)
        assert_type(observation, BatchObservation)
        assert_type(observation.ranges, Float32Array)
        assert_type(observation.poses, FloatArray)
        observation = batch.reset(mask=observation.collided, poses=[(0.0, 0.0, 0.0)] * 8)
        return observation.collided


def follow(run: SweepRun, speed: float = 0.5) -> None:
    """A controller of a sweep."""
    while run.is_running:
        run.robot.command(speed, run.bearing)
        assert_type(run.step(), bool)

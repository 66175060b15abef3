"""A controller that knows where all are: optimal reciprocal collision avoidance (ORCA)."""

import math
from typing import List, Sequence

import numpy as np

from flatland2d.sweep.run import SweepRun
from flatland_server._core import orca_velocity
from flatland_server.array_math import from_segments
from flatland_server.arrays import FloatArray, Segments


def orca(
    run: SweepRun,
    speed: float = 0.8,
    horizon: float = 3.0,
    wall_horizon: float = 1.0,
    distance: float = 5.0,
    share: float = 1.0,
    margin: float = 0.05,
) -> None:
    """Drives straight at the goal, but for the least change that avoids collisions.

    It is told poses and velocities of other models instead of measuring them, and plans no path
    around walls. J. van den Berg, S. J. Guy, M. Lin and D. Manocha, "Reciprocal n-body collision
    avoidance", Robotics Research, 2011. A robot that cannot drive sideways turns towards the chosen
    velocity, and drives at its part that is ahead.

    Args:
        run: the scenario's run; it must have a goal.
        speed: the largest [m/s].
        horizon: time without collisions with other models [s].
        wall_horizon: with walls [s].
        distance: up to which other models count [m].
        share: of the avoidance that it makes, 0.5 if others make the rest.
        margin: added to its radius [m].
    """
    radius = run.robot.model.radius + margin
    body = run.robot.model.base.physics_body
    world = run.simulation.world
    walls = np.concatenate([np.empty((0, 4)), *(layer.segments for layer in world.layers)])
    while run.is_running and run.goal is not None:
        pose = run.robot.pose
        neighbors: List[List[float]] = []
        for model in world.models.values():
            offset = model.pose.x - pose.x, model.pose.y - pose.y
            if model is run.robot.model or math.hypot(*offset) - model.radius > distance:
                continue
            velocity = model.base.physics_body.velocity[:2]
            neighbors.append([*offset, *velocity, radius + model.radius, share])
        way = np.array(run.goal[:2]) - pose[:2]
        preferred = way * (speed / max(float(np.hypot(*way)), 0.3))
        chosen = orca_velocity(
            body.velocity[:2],
            preferred,
            np.array(neighbors, float).reshape(-1, 6),
            _seen(walls, pose[:2], radius, speed * wall_horizon),
            most=speed,
            horizon=horizon,
            wall_horizon=wall_horizon,
            dt=0.1,
        )
        bearing = math.atan2(chosen[1], chosen[0]) - pose.yaw
        bearing = math.remainder(bearing, math.tau) if any(chosen) else 0.0
        ahead = max(0.0, math.cos(bearing)) * math.hypot(*chosen)
        run.robot.command(ahead, 3.0 * bearing)
        run.step()


def _seen(walls: Segments, place: Sequence[float], radius: float, reach: float) -> FloatArray:
    """Gaps [m] of walls within reach [m], and the directions away from them, shape (n, 3)."""
    away = from_segments(np.array([place]), walls)[0]
    distances = np.maximum(np.hypot(away[:, 0], away[:, 1]), 1e-9)
    rows = np.column_stack([distances - radius, away / distances[:, None]])
    return np.ascontiguousarray(rows[distances < radius + reach])

"""The length of the shortest path from a start to a goal: how far a task is."""

from functools import lru_cache
from typing import List, Optional, Tuple

import numpy as np

from flatland2d.handles import ModelHandle
from flatland2d.simulation import Simulation
from flatland_navigation.grid import Grid
from flatland_navigation.planner import PlanningError, plan
from flatland_server.arrays import FloatArray
from flatland_server.geometry import Point

_ROOM = 5.0  # m, around start and goal, where a path may lead without walls


def shortest_path(
    simulation: Simulation, robot: ModelHandle, goal: Point, goal_radius: float
) -> Optional[float]:
    """The length of a shortest path of a disc around the robot, past walls and static bodies.

    It is found by A* on cells of 0.1 m, and then pulled tight: a straight path is exact, others are
    up to a few per cent too long.

    Args:
        simulation: simulation with the robot at its start.
        robot: the driven model.
        goal: x, y [m].
        goal_radius: distance at which the goal is reached [m].

    Returns:
        The length up to that distance [m]; None if the disc does not get there.
    """
    start = robot.pose[:2]
    walls = framed(obstacles(simulation, robot), start, goal)
    try:
        path = plan(_grid(walls.tobytes(), robot.model.radius), start, goal)
    except (PlanningError, ValueError):
        return None
    return max(0.0, float(np.hypot(*np.diff(path, axis=0).T).sum()) - goal_radius)


def obstacles(simulation: Simulation, robot: ModelHandle) -> FloatArray:
    """The walls, and the outlines of other models' static bodies: shape (n, 4) [m]."""
    walls = [layer.segments for layer in simulation.world.layers]
    others = [each for each in simulation.models.values() if each.name != robot.name]
    return np.concatenate([np.empty((0, 4)), *walls, *map(_standing, others)])


def framed(walls: FloatArray, start: Point, goal: Point) -> FloatArray:
    """Walls with two points beyond start and goal, so that a grid reaches there: shape (n, 4)."""
    low, high = np.minimum(start, goal) - _ROOM, np.maximum(start, goal) + _ROOM
    return np.vstack([walls, [[*low, *low]], [[*high, *high]]])


def _standing(model: ModelHandle) -> FloatArray:
    """The outlines of a model's static bodies in the world: shape (n, 4)."""
    lines: List[Tuple[float, float, float, float]] = []
    for body in model.model.bodies.values():
        for footprint in body.config.footprints if body.config.type == "static" else ():
            corners = [body.pose.apply(*corner) for corner in footprint.shape.outline()]
            lines += [(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1])]
    return np.array(lines, np.float64).reshape(-1, 4)


@lru_cache(maxsize=4)
def _grid(walls: bytes, radius: float) -> Grid:
    return Grid.from_walls(np.frombuffer(walls).reshape(-1, 4), radius)

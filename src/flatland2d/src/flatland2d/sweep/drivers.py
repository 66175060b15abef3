"""Controllers that drive to the goal of a run with a lidar: to compare with, and to start from."""

import math
from typing import Any, Dict

import numpy as np

from flatland2d.sweep.run import SweepRun
from flatland2d.sweep.shortest_path import framed, obstacles
from flatland_navigation.follower import FollowerConfig
from flatland_navigation.grid import Grid
from flatland_navigation.navigator import Navigator, NavigatorConfig, Status
from flatland_navigation.obstacles import scan_points
from flatland_server.arrays import FloatArray
from flatland_server.geometry import Pose

_MAX_DIRECTIONS = 128
_MARGIN = 0.07  # m, of planned paths


def gaps(
    run: SweepRun,
    sensor: str = "laser",
    speed: float = 0.6,
    distance: float = 1.0,
    margin: float = 0.15,
) -> None:
    """Drives in the free direction that is nearest to the goal's. It has no map.

    Args:
        run: the scenario's run; it must have a goal.
        sensor: name of the robot's lidar.
        speed: [m/s].
        distance: up to which obstacles count [m].
        margin: from obstacles [m].
    """
    lidar = run.robot.sensors[sensor]
    radius = run.robot.model.radius
    count = len(lidar.angles)
    size = -(-count // _MAX_DIRECTIONS)  # beams of a direction
    firsts = np.arange(0, count, size)
    lasts = np.minimum(firsts + size, count) - 1
    directions = (lidar.angles[firsts] + lidar.angles[lasts]) / 2.0
    between = _apart(directions[:, None], directions)
    while run.is_running:
        nearest = np.minimum.reduceat(np.nan_to_num(lidar.read(), nan=np.inf), firsts)
        ranges = np.maximum(nearest, radius)
        hides = np.arcsin(np.minimum(1.0, (radius + margin) / ranges))  # on either side [rad]
        is_near = ranges < min(distance, run.distance)
        is_free = ~(is_near & (hides > between)).any(axis=1)
        heading = directions[np.argmin(_apart(directions, run.bearing) + 10.0 * ~is_free)]
        is_ahead = is_free.any() and abs(heading) < 0.5
        run.robot.command(speed if is_ahead else 0.0, 2.0 * heading)
        run.step()


def planner(
    run: SweepRun, sensor: str = "laser", speed: float = 0.5, has_map: bool = True
) -> Dict[str, Any]:
    """Plans a path, stops for what its lidar sees, and plans a way around it; may give up.

    Args:
        run: the scenario's run; it must have a goal.
        sensor: name of the robot's lidar.
        speed: the largest [m/s].
        has_map: whether it knows walls and static bodies from the beginning.

    Returns:
        `navigator`: the state in which its navigator has ended.
    """
    lidar = run.robot.sensors[sensor]
    radius = run.robot.model.radius
    follower = FollowerConfig(max_speed=speed)
    config = NavigatorConfig(robot_radius=radius, stuck_after=20.0, follower=follower)
    goal = Pose(*run.goal) if run.goal is not None else run.robot.pose
    walls = obstacles(run.simulation, run.robot) if has_map else np.empty((0, 4))
    walls = framed(walls, run.robot.pose[:2], goal[:2])
    navigator = Navigator(Grid.from_walls(walls, radius + _MARGIN), config)
    navigator.set_goal(goal)
    increment = (lidar.angles[-1] - lidar.angles[0]) / max(1, len(lidar.angles) - 1)
    while run.is_running and navigator.status is Status.ACTIVE:
        pose = run.robot.pose
        seen = scan_points(lidar.read(), lidar.angles[0], increment, lidar.range_max, pose)
        navigator.observe(seen, run.time)
        command = navigator.update(pose, run.time)
        run.robot.command(command.forwards, command.turn)
        run.step()
    return {"navigator": navigator.status.name.lower()}


def _apart(directions: FloatArray, other: Any) -> FloatArray:
    """The angles between directions [rad]."""
    return np.asarray(np.abs((directions - other + math.pi) % math.tau - math.pi))

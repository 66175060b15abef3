"""Controllers of scenarios.yaml. They return when the run is over."""

import numpy as np

from flatland2d import Pose
from flatland_navigation.grid import Grid
from flatland_navigation.navigator import Navigator, NavigatorConfig
from flatland_navigation.obstacles import scan_points

RADIUS = 0.2  # of the robot [m]
RANGE = 10.0  # of its lidar [m]
BEAMS = np.linspace(-np.pi, np.pi, 64, endpoint=False)  # directions of its lidar's beams [rad]


def angles(directions, other):
    """The angles between directions [rad]."""
    return np.abs((directions - other + np.pi) % (2.0 * np.pi) - np.pi)


BETWEEN = angles(BEAMS[:, None], BEAMS)


def gaps(run, speed=0.6, distance=1.0, margin=0.15):
    """Drives in the free direction that is nearest to the goal's. It has no map."""
    lidar = run.robot.sensors["laser"]
    while run.is_running:
        ranges = np.maximum(lidar.read(), RADIUS)
        hides = np.arcsin(np.minimum(1.0, (RADIUS + margin) / ranges))  # on either side [rad]
        is_near = ranges < min(distance, run.distance)
        is_free = ~(is_near & (hides > BETWEEN)).any(axis=1)
        heading = BEAMS[np.argmin(angles(BEAMS, run.bearing) + 10.0 * ~is_free)]
        is_ahead = is_free.any() and abs(heading) < 0.5
        run.robot.command(speed if is_ahead else 0.0, 2.0 * heading)
        run.step()


def planner(run):
    """Plans a path on the map, stops for what its lidar sees, and plans a way around it."""
    walls = np.concatenate([layer.segments for layer in run.simulation.world.layers])
    config = NavigatorConfig(robot_radius=RADIUS, stuck_after=20.0)
    navigator = Navigator(Grid.from_walls(walls, RADIUS + 0.07), config)
    navigator.set_goal(Pose(*run.goal))
    lidar = run.robot.sensors["laser"]
    while run.is_running:
        pose = Pose(*run.robot.pose)
        points = scan_points(lidar.read(), BEAMS[0], BEAMS[1] - BEAMS[0], RANGE, pose)
        navigator.observe(points, run.time)
        command = navigator.update(pose, run.time)
        run.robot.command(command.forwards, command.turn)
        run.step()
    return {"navigator": navigator.status.name.lower()}

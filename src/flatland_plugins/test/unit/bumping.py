"""Shared by the tests of Bumper: robots thrown and pushed at walls, and their collisions."""

import math
from typing import Any, List, Tuple

from flatland_msgs.msg import Collision, Collisions

BUMPER = "type: Bumper, name: bumper"
STEP = 0.005
RADIUS, MASS = 0.2, 0.04 * math.pi * 10  # of the disc of conftest.py
CORNERS = "[[-0.25, -0.25], [0.25, -0.25], [0.25, 0.25], [-0.25, 0.25]]"
BOX = f"{{type: polygon, points: {CORNERS}, density: 4}}"  # 1 kg
DISC = f"{{type: circle, radius: {RADIUS}, density: 10}}"

SKIN = 0.02
"""Accuracy of Box2D's contact points of two shapes [m]: each has a skin of up to 1 cm."""


def wall(files, *segments: str, name: str = "walls") -> Tuple[str, ...]:
    """A layer of walls, by default one across the x axis at 1 m."""
    return (f"name: {name}, map: {files.walls('wall', *(segments or ['1 -3 1 3']))}",)


def throw(robot, vx: float, vy: float = 0.0, name: str = "robot"):
    """Sets a model's velocity."""
    robot.model(name).base.physics_body.velocity = (vx, vy, 0.0)
    return robot


def press(robot, force: Tuple[float, float], seconds: float, at: Tuple[float, float] = (0.0, 0.0)):
    """Pushes the robot for a time [s], at a point of its body."""
    body = robot.model().base.physics_body
    for _ in range(round(seconds / STEP)):
        body.apply_force(force, body.world_point(at))
        robot.run()
    return robot


def record(robot, seconds: float, topic: str = "/collisions") -> List[Collision]:
    """Runs for a time [s]; returns the reported collisions in order."""
    return [each for message in robot.record(topic, seconds) for each in message.collisions]


def impulse(collisions: List[Collision]) -> float:
    """The total impulse on the robot, over all points and steps [N s]."""
    return sum(sum(each.magnitude_forces) for each in collisions) * STEP


def now(robot, topic: str = "/collisions") -> List[Collision]:
    message = robot.last(topic)
    assert isinstance(message, Collisions)
    return list(message.collisions)


def vectors(points: Any) -> List[Tuple[float, float]]:
    return [(point.x, point.y) for point in points]


def names(collision: Collision) -> Tuple[str, str, str, str]:
    return collision.entity_A, collision.body_A, collision.entity_B, collision.body_B

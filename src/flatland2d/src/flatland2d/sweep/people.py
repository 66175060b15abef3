"""Distances of a robot from people, collisions with them, and the time in their zones.

The zones are those of E. T. Hall, "The Hidden Dimension" (1966): intimate up to 0.45 m, personal up
to 1.2 m, social up to 3.6 m. As for clearances, a distance is that between the outlines: from the
robot's footprints to the circle around a person.

The group crossing rate is that of U. K. Roy and S. Rahman, "TAGA: A Tangent-Based Reactive Approach
for Socially Compliant Robot Navigation Around Human Groups" (arXiv:2503.21168, version 3; its first
version calls it the group collision rate): the part of the time in which the robot's origin is in
the convex hull of a group. The hull is that of circles, so that two people have one, too.
"""

from typing import Any, Dict, List, Mapping, Sequence, Tuple

import numpy as np

from flatland_server.array_math import cos_sin, from_segments
from flatland_server.arrays import FloatArray
from flatland_server.geometry import Point
from flatland_server.models import Circle, Model
from flatland_server.plugins import Plugin
from flatland_server.simulation import World

ZONES = {"intimate_fraction": 0.45, "personal_fraction": 1.2, "social_fraction": 3.6}
"""The outer end of each zone [m]."""


_STANDING = 0.05  # m/s
_DIRECTIONS = np.stack(cos_sin(np.radians(np.arange(360.0))), axis=-1)

Twist = Tuple[float, float, float]


def people_of(world: World) -> List[Model]:
    """The models that plugins move as people."""
    return [model for plugin in _plugins_of(world) for model in plugin.people]


def _plugins_of(world: World) -> List[Plugin]:
    owners = ("", *world.models)
    return [plugin for owner in owners for plugin in world.plugins_of(owner).values()]


class PeopleMetrics:
    """Measures the distance from the nearest person at control steps."""

    def __init__(self, world: World, robot: Model) -> None:
        self._world = world
        self._robot = robot
        self._distances: List[float] = []
        self._durations: List[float] = []
        self._is_crowded = bool(people_of(world))
        self._grouping = [plugin for plugin in _plugins_of(world) if plugin.groups]
        self._time = self._time_in_groups = 0.0
        self._collision: Dict[str, Any] = {"person_collision": False, "robot_at_fault": False}

    def velocities(self) -> Dict[str, Twist]:
        """Velocities of the robot and the people [m/s, m/s, rad/s], by name; none without people.

        Of the origins of their first bodies.
        """
        if not self._is_crowded:
            return {}
        models = (self._robot, *people_of(self._world))
        return {model.name: model.base.physics_body.velocity for model in models}

    def note_collision(self, other: str, velocities: Mapping[str, Twist]) -> None:
        """Notes the first collision of the robot.

        Args:
            other: the model or layer that it has hit.
            velocities: of the robot and the people, by name, before the step of the collision.
        """
        if other not in velocities:
            return
        speeds = [np.array(velocities[name][:2]) for name in (self._robot.name, other)]
        way = np.subtract(self._world.models[other].pose[:2], self._robot.pose[:2])
        towards = float(speeds[0] @ way) / max(float(np.hypot(*way)), 1e-9)
        self._collision = {
            "person_collision": True,
            "robot_at_fault": towards > _STANDING,
            "robot_speed_at_contact": float(np.hypot(*speeds[0])),
            "person_speed_at_contact": float(np.hypot(*speeds[1])),
        }

    def measure(self, duration: float) -> None:
        """Measures after a control step; nothing while there are no people.

        Args:
            duration: the control step's duration [s].
        """
        self._time += duration
        groups = [group for plugin in self._grouping for group in plugin.groups]
        if any(is_among(self._robot.pose[:2], group) for group in groups):
            self._time_in_groups += duration
        people = [each for each in people_of(self._world) if not each.is_away]
        if people:
            edges, radii = _outlines(self._robot)
            places = np.array([person.pose[:2] for person in people])
            away = np.sqrt((from_segments(places, edges) ** 2).sum(axis=2)) - radii
            distances = away.min(axis=1) - np.array([person.radius for person in people])
            self._distances.append(max(0.0, float(distances.min())))
            self._durations.append(duration)

    def values(self) -> Dict[str, Any]:
        """The metrics so far, by their names; none without people.

        - `person_collision`: whether a person was hit first.
        - `robot_at_fault`: whether that was so, and the robot moved towards the person.
        - `robot_speed_at_contact`, `person_speed_at_contact`: before that collision [m/s].
        - `people_distance`: the least distance from the nearest person [m].
        - `mean_people_distance`: the mean over control steps, by their durations [m].
        - `intimate_fraction`, `personal_fraction`, `social_fraction`: of the time, in which the
          nearest person was at that distance.
        - `group_crossing_rate`: of the time, in which the robot was among people of a group.
        """
        if not self._is_crowded:
            return {}
        found: Dict[str, Any] = dict(self._collision)
        if self._grouping and self._time:
            found["group_crossing_rate"] = self._time_in_groups / self._time
        if not self._distances:
            return found
        distances, durations = np.array(self._distances), np.array(self._durations)
        found["people_distance"] = float(distances.min())
        found["mean_people_distance"] = float(np.average(distances, weights=durations))
        nearer = 0.0
        for name, end in ZONES.items():
            inside = durations[(distances >= nearer) & (distances < end)]
            found[name] = float(inside.sum() / durations.sum())
            nearer = end
        return found


def is_among(point: Point, people: Sequence[Model]) -> bool:
    """True if a point is in the convex hull of the circles around people.

    It is outside if all circles lie on one side of a line through it. Lines a degree apart are
    tried.
    """
    centers = np.array([person.pose[:2] for person in people]) - point
    reach = _DIRECTIONS @ centers.T + [person.radius for person in people]
    return bool((reach.max(axis=1) >= 0.0).all())


def _outlines(model: Model) -> Tuple[FloatArray, FloatArray]:
    """Edges of polygons and centers of circles in the world [m]: shape (n, 4); and their radii."""
    edges: List[Tuple[float, float, float, float]] = []
    radii: List[float] = []
    for body in model.bodies.values():
        for footprint in body.config.footprints:
            shape = footprint.shape
            if isinstance(shape, Circle):
                corners, radius = [shape.center], shape.radius
            else:
                corners, radius = list(shape.vertices), 0.0
            placed = [body.pose.apply(*corner) for corner in corners]
            edges += [(*a, *b) for a, b in zip(placed, [*placed[1:], placed[0]])]
            radii += [radius] * len(placed)
    return np.array(edges), np.array(radii)

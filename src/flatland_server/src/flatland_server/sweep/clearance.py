"""The distance between a robot and what it could hit: walls, and the footprints of other models.

Distances are exact for discs and polygons. Most calls compare a few numbers only: a robot that has
moved by d is nearer to a wall by d at most, so that walls are compared again only if one could be
nearer than all before.
"""

import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from flatland_server import _core
from flatland_server.arrays import FloatArray, Segments
from flatland_server.models.footprint import Circle, Footprint
from flatland_server.models.model import Model
from flatland_server.simulation.world import World

_REACH = 1.0
"""Walls are looked up that are so much farther away than the nearest one [m]; see `_Walls`."""


class _Outline(NamedTuple):
    """A footprint in its body's frame: points, or the corners of a polygon, with a radius."""

    points: FloatArray  # (n, 2) [m]
    radius: float  # [m]
    layers: int

    @property
    def reach(self) -> float:
        """The greatest distance of one of its points from the body's origin [m]."""
        return float(np.hypot(self.points[:, 0], self.points[:, 1]).max()) + self.radius

    def placed(self, pose: Sequence[float]) -> FloatArray:
        """Its points in the world: shape (n, 2)."""
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        turned = self.points @ np.array([[cos, sin], [-sin, cos]])
        return np.asarray(turned + np.array(pose[:2]))


class _Walls:
    """The walls near a body, looked up again when it has moved on."""

    def __init__(self, segments: Segments, outlines: Sequence[_Outline]) -> None:
        self._segments = segments
        self._outlines = outlines
        self._reach = max(outline.reach for outline in outlines)
        self._near = segments
        self._looked_up: Optional[Tuple[float, float]] = None
        self._known: Optional[Tuple[float, Sequence[float]]] = None  # a distance, and at which pose

    def distance(self, pose: Sequence[float], shortest: float) -> float:
        """The distance [m] if it is shorter than `shortest`; else a lower bound that is not."""
        if self._known is not None:
            before, where = self._known
            turned = abs(math.remainder(pose[2] - where[2], math.tau))
            bound = before - math.dist(pose[:2], where[:2]) - turned * self._reach
            if bound >= shortest:
                return bound
        if self._looked_up is None or math.dist(self._looked_up, pose[:2]) > _REACH / 2:
            self._look_up(pose)
        distances = [
            _distance(outline.placed(pose), outline.radius, self._near)
            for outline in self._outlines
        ]
        self._known = min(distances), tuple(pose)
        return self._known[0]

    def _look_up(self, pose: Sequence[float]) -> None:
        """Finds the walls that can be the nearest one until the body has moved half of `_REACH`."""
        place = np.array([pose[:2]], dtype=float)
        distances = _to_segments(place, self._segments)[0]
        self._near = self._segments[distances <= distances.min() + 2 * self._reach + _REACH]
        self._looked_up = (pose[0], pose[1])


class Clearance:
    """Measures how near a robot gets to what it could hit.

    Footprints count that collide, are no sensors, and share a layer with one of the robot's.

    Args:
        world: the world.
        robot: a model in it.

    Attributes:
        least: the shortest distance that was measured so far [m]; infinite in an empty world.
    """

    def __init__(self, world: World, robot: Model) -> None:
        self.least = math.inf
        self._world = world
        self._robot = robot
        self._bodies = [
            (body.physics_body, _outlines(body.config.footprints)) for body in robot.bodies.values()
        ]
        self._walls: List[Tuple[_core.Body, _Walls]] = []
        self._wall_count = -1
        self._others: List[Tuple[_core.Body, List[_Outline]]] = []
        self._group = _core.BodyGroup([])
        self._models: Tuple[Model, ...] = ()

    def measure(self) -> None:
        """Measures now."""
        self._look_up()
        for body, walls in self._walls:
            self.least = min(self.least, walls.distance(body.pose, self.least))
        if not self._others:
            return
        poses = self._group.poses()
        for body, outlines in self._bodies:
            if outlines:
                self._measure_models(body.pose, outlines, poses)

    def touch(self) -> None:
        """Notes that the robot has touched something."""
        self.least = 0.0

    def _measure_models(
        self, pose: Sequence[float], outlines: Sequence[_Outline], poses: FloatArray
    ) -> None:
        """Measures from a body of the robot to the bodies of other models."""
        reach = max(outline.reach for outline in outlines)
        apart = np.hypot(poses[:, 0] - pose[0], poses[:, 1] - pose[1]) - reach
        for index in np.flatnonzero(apart - self._reaches < self.least):
            for other in self._others[index][1]:
                corners = other.placed(poses[index])
                for outline in outlines:
                    if outline.layers & other.layers:
                        distance = _between(outline.placed(pose), outline.radius, corners)
                        self.least = min(self.least, max(0.0, distance - other.radius))

    def _look_up(self) -> None:
        """Notes walls and models that have come since the last call."""
        layers = self._world.layers
        count = sum(len(layer.segments) for layer in layers)
        if count != self._wall_count:
            self._wall_count = count
            self._walls = []
            for body, outlines in self._bodies:
                bits = [(layer.segments, layer.config.bits) for layer in layers]
                for segments, layer_bits in bits:
                    hit = [outline for outline in outlines if outline.layers & layer_bits]
                    if hit and len(segments):
                        self._walls.append((body, _Walls(segments, hit)))
        models = tuple(each for each in self._world.models.values() if each is not self._robot)
        if models != self._models:
            self._models = models
            bodies = [body for model in models for body in model.bodies.values()]
            pairs = [(body.physics_body, _outlines(body.config.footprints)) for body in bodies]
            self._others = [pair for pair in pairs if pair[1]]
            self._group = _core.BodyGroup([body for body, _ in self._others])
            self._reaches = np.array([max(o.reach for o in found) for _, found in self._others])


def _outlines(footprints: Sequence[Footprint]) -> List[_Outline]:
    """The footprints that something can hit."""
    found = []
    for footprint in footprints:
        if footprint.collision and not footprint.sensor and footprint.layer_bits:
            shape = footprint.shape
            if isinstance(shape, Circle):
                points, radius = np.array([shape.center], dtype=float), shape.radius
            else:
                points, radius = np.array(shape.vertices, dtype=float), 0.0
            found.append(_Outline(points, radius, footprint.layer_bits))
    return found


def _edges(corners: FloatArray) -> Segments:
    """The sides of a polygon, or a point as a segment without length."""
    return np.hstack([corners, np.roll(corners, -1, axis=0)])


def _between(points: FloatArray, radius: float, corners: FloatArray) -> float:
    """The distance of an outline, with a radius, from a polygon or a point; 0 if they overlap."""
    if _contains(corners, points[0]) or _contains(points, corners[0]):
        return 0.0
    return _distance(points, radius, _edges(corners))


def _distance(points: FloatArray, radius: float, segments: Segments) -> float:
    """The distance of an outline, with a radius, from segments; 0 if they cross."""
    nearest = float(_to_segments(points, segments).min())
    if len(points) > 1:
        edges = _edges(points)
        ends = segments.reshape(-1, 2)
        nearest = min(nearest, float(_to_segments(ends, edges).min()))
        if _cross(edges, segments):
            nearest = 0.0
    return max(0.0, nearest - radius)


def _to_segments(points: FloatArray, segments: Segments) -> FloatArray:
    """The distances of n points from m segments: shape (n, m)."""
    begin, way = segments[:, :2], segments[:, 2:] - segments[:, :2]
    square = np.einsum("ij,ij->i", way, way)
    offset = points[:, None, :] - begin
    along = np.einsum("nmj,mj->nm", offset, way) / np.where(square > 0.0, square, 1.0)
    rest = offset - np.clip(along, 0.0, 1.0)[:, :, None] * way
    return np.asarray(np.hypot(rest[:, :, 0], rest[:, :, 1]))


def _cross(edges: Segments, segments: Segments) -> bool:
    """Whether one of the edges crosses one of the segments."""
    a, b = edges[:, None, :2], edges[:, None, 2:]
    c, d = segments[None, :, :2], segments[None, :, 2:]
    sides = _side(a, b, c) * _side(a, b, d), _side(c, d, a) * _side(c, d, b)
    return bool(((sides[0] < 0.0) & (sides[1] < 0.0)).any())


def _side(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Positive for points c to the left of the line from a to b."""
    way, other = b - a, c - a
    return np.asarray(way[..., 0] * other[..., 1] - way[..., 1] * other[..., 0])


def _contains(corners: FloatArray, point: FloatArray) -> bool:
    """Whether a point is within a convex polygon."""
    if len(corners) < 3:
        return False
    sides = _side(corners, np.roll(corners, -1, axis=0), point[None, :])
    return bool((sides > 0.0).all() or (sides < 0.0).all())

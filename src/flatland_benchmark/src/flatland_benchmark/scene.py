"""Scenes for ray casts: the same walls and bodies in Flatland, in Box2D, and as arrays."""

from typing import List, NamedTuple, Tuple, Union

import numpy as np

from flatland_benchmark import _box2d_rays
from flatland_benchmark.exact_rays import (
    distances_to_circle,
    distances_to_polygon,
    distances_to_segments,
)
from flatland_benchmark.outlines import trace_outlines
from flatland_server.arrays import FloatArray
from flatland_server.geometry import Pose
from flatland_server.simulation.world import World

Point = Tuple[float, float]


class Circle(NamedTuple):
    """A footprint, in its body's frame [m]."""

    center: Point
    radius: float


class Polygon(NamedTuple):
    """A convex footprint, counter-clockwise, in its body's frame [m]."""

    vertices: Tuple[Point, ...]


class Body(NamedTuple):
    """A dynamic body at rest."""

    pose: Pose
    footprints: Tuple[Union[Circle, Polygon], ...]


class Scene:
    """Walls and bodies, and the poses of the lidar.

    Args:
        world: has the walls; the bodies are added to it.
        poses: of the lidar.
        bodies: all of them visible to lidars.
    """

    def __init__(self, world: World, poses: List[Pose], bodies: Tuple[Body, ...] = ()) -> None:
        self.world = world
        self.poses = poses
        self.bodies = bodies
        self.segments = np.concatenate([layer.segments for layer in world.layers])
        for body in bodies:
            handle = world.physics.add_body("dynamic", body.pose)
            for footprint in body.footprints:
                # Without collisions: they may overlap, and stay where they are.
                if isinstance(footprint, Circle):
                    handle.add_circle(*footprint, density=1.0, collides=False)
                else:
                    handle.add_polygon(*footprint, density=1.0, collides=False)

    def in_box2d(self) -> List[_box2d_rays.World]:
        """The scene in Box2D, for several orders of insertion: its speed depends on them."""
        outlines = trace_outlines(self.segments)
        longest_first = sorted(outlines, key=len, reverse=True)
        return [self._insert(order) for order in (outlines, outlines[::-1], longest_first)]

    def _insert(self, outlines: List[FloatArray]) -> _box2d_rays.World:
        world = _box2d_rays.World()
        world.add_walls(np.concatenate(outlines))
        for body in self.bodies:
            index = world.add_body(body.pose)
            for footprint in body.footprints:
                if isinstance(footprint, Circle):
                    world.add_circle(index, footprint.center, footprint.radius)
                else:
                    world.add_polygon(index, footprint.vertices)
        return world

    def exact_distances(self, origins: FloatArray, directions: FloatArray) -> FloatArray:
        """Distance along each ray [m] to the first wall or body; infinity if there is none.

        Args:
            origins: in the world [m], shape (n, 2).
            directions: unit vectors in the world, shape (n, 2).
        """
        nearest = distances_to_segments(origins, directions, self.segments)
        for body in self.bodies:
            for footprint in body.footprints:
                if isinstance(footprint, Circle):
                    center = body.pose.apply(*footprint.center)
                    distances = distances_to_circle(origins, directions, center, footprint.radius)
                else:
                    vertices = [body.pose.apply(*vertex) for vertex in footprint.vertices]
                    distances = distances_to_polygon(origins, directions, vertices)
                nearest = np.minimum(nearest, distances)
        return nearest

"""The obstacles of a crowd: the walls of layers, and the models that do not belong to it."""

from typing import Callable, Collection, Dict, List, Sequence, Tuple

import numpy as np

from flatland_plugins.social_force import Others
from flatland_plugins.wall_grid import WallGrid, nearest
from flatland_server import Circle, FloatArray, Footprint, Model, ModelBody, Segments, cos_sin


class Walls:
    """The walls of some layers, including walls that are added later.

    Args:
        find: returns the present walls of each layer.
        reach: distance from a point within which walls are found [m].
    """

    def __init__(self, find: Callable[[], Sequence[Segments]], reach: float) -> None:
        self._find = find
        self._reach = reach
        self._count = -1

    def seen_from(self, points: FloatArray) -> Others:
        """Distances from the walls around points (n, 2), and directions; see `WallGrid.walls`."""
        walls = self._find()
        count = sum(map(len, walls))
        if count != self._count:
            self._grid = WallGrid(np.concatenate([np.empty((0, 4)), *walls]), self._reach)
            self._count = count
        return self._grid.walls(points)


def seen_walls(walls: Sequence[Walls], points: FloatArray) -> Others:
    """Distances from the walls of n worlds, and directions, at p points in each: n * p rows."""
    if all(each is walls[0] for each in walls):
        return walls[0].seen_from(points.reshape(-1, 2))
    seen = [each.seen_from(place) for each, place in zip(walls, points)]
    width = max(each.distances.shape[1] for each in seen)
    distances = np.full((*points.shape[:2], width), np.inf)
    away = np.zeros((*points.shape[:2], width, 2))
    for row, each in enumerate(seen):
        count = each.distances.shape[1]
        distances[row, :, :count], away[row, :, :count] = each
    rows = points.shape[0] * points.shape[1]
    return Others(distances.reshape(rows, width), away.reshape(rows, width, 2))


class Outline:
    """The solid footprints of a body, as lines; a disc is a point with a radius.

    Attributes:
        body: the body in the physical world.
    """

    def __init__(self, body: ModelBody, footprints: Sequence[Footprint]) -> None:
        self.body = body.physics_body
        lines, radii = [], []
        for footprint in footprints:
            shape = footprint.shape
            corners = [shape.center] if isinstance(shape, Circle) else list(shape.vertices)
            lines.append(np.hstack([corners, np.roll(corners, -1, axis=0)]))
            radii += [shape.radius if isinstance(shape, Circle) else 0.0] * len(corners)
        self._lines = np.concatenate(lines)
        self._radii = np.array(radii)

    def seen_from(self, points: FloatArray, poses: FloatArray) -> Others:
        """Distances (n,) from its nearest point, and directions away from it (n, 2).

        Args:
            points: [m], shape (n, 2).
            poses: of the body, one for each point [m, m, rad], shape (n, 3).
        """
        x, y, yaw = poses.T[..., np.newaxis]
        cos, sin = cos_sin(yaw)
        lines = np.empty((len(points), *self._lines.shape))
        for i in (0, 2):
            along, across = self._lines[:, i], self._lines[:, i + 1]
            lines[..., i] = cos * along - sin * across + x
            lines[..., i + 1] = sin * along + cos * across + y
        distances, away = nearest(points, lines)
        distances -= self._radii
        index = distances.argmin(axis=1)
        each = np.arange(len(points))
        return Others(distances[each, index], away[each, index])


class Bodies:
    """The bodies of a world's models, each an obstacle.

    Args:
        models: the world's models by name, which may change.
        layers: bits of the collision layers of the people.
    """

    def __init__(self, models: Dict[str, Model], layers: int) -> None:
        self._models = models
        self._layers = layers
        self._outlines: Dict[Tuple[Model, int], List[Outline]] = {}

    def find(self, but: Collection[Model]) -> List[Outline]:
        """The present bodies of all models but some."""
        present = [(m, m.footprint_revision) for m in self._models.values() if m not in but]
        self._outlines = {
            key: self._outlines.get(key) or self._outlines_of(key[0]) for key in present
        }
        return [outline for outlines in self._outlines.values() for outline in outlines]

    def _outlines_of(self, model: Model) -> List[Outline]:
        outlines = []
        for body in model.bodies.values():
            footprints = [f for f in body.config.footprints if self._can_be_touched(f)]
            if footprints:
                outlines.append(Outline(body, footprints))
        return outlines

    def _can_be_touched(self, footprint: Footprint) -> bool:
        return (
            footprint.collision
            and not footprint.sensor
            and bool(footprint.layer_bits & self._layers)
        )


def seen_from(points: FloatArray, outlines: Sequence[Outline], poses: FloatArray) -> Others:
    """Distances (n, m) of points (n, 2) from outlines at poses (n, m, 3); directions (n, m, 2)."""
    seen = [each.seen_from(points, poses[:, index]) for index, each in enumerate(outlines)]
    return Others(
        np.array([one.distances for one in seen]).reshape(len(seen), len(points)).T,
        np.array([one.away for one in seen]).reshape(len(seen), len(points), 2).swapaxes(0, 1),
    )

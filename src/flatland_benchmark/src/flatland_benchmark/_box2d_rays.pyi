"""Lidar scans by b2World::RayCast, beam by beam: the reference of the benchmark.

Lengths are in m, angles in rad. Contains no code of Flatland's core.
"""

from typing import Sequence

from flatland_server.arrays import FloatArray, Segments

_Pair = tuple[float, float]
_Triple = tuple[float, float, float]

class _Metaclass(type):
    """The metaclass of pybind11."""

class World(metaclass=_Metaclass):
    """Bodies and walls in a b2World."""

    def __init__(self) -> None: ...
    def add_walls(self, segments: Segments) -> None:
        """Adds walls, each a two-sided edge of one static body, in this order.

        Box2D's search tree, and so its speed, depends on the order.

        Args:
            segments: shape (n, 4), rows of x1, y1, x2, y2 [m].
        """
    def add_body(self, pose: _Triple) -> int:
        """Adds a dynamic body without fixtures, at a pose [m, m, rad]; returns its index."""
    def add_circle(self, body: int, center: _Pair, radius: float) -> None:
        """Adds a disc to the body of this index, in its frame [m]."""
    def add_polygon(self, body: int, vertices: Sequence[_Pair]) -> None:
        """Adds the convex hull of 3 to 8 vertices to the body of this index, in its frame [m]."""
    def scan(self, directions: FloatArray, pose: _Triple, range: float) -> FloatArray:
        """Casts one ray of length `range` after the other.

        Args:
            directions: shape (n, 2), unit vectors in the lidar's frame.
            pose: of the lidar, in the world [m, m, rad].
            range: length of each ray [m].

        Returns:
            Shape (n,): the distance to the first hit of each ray [m], or +infinity.
        """

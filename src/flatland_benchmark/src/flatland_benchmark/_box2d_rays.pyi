"""Lidar scans by b2World::RayCast, beam by beam: the baseline of the benchmark's ray cases."""

from typing import Sequence

from flatland_server.arrays import FloatArray, Segments

_Pair = tuple[float, float]
_Triple = tuple[float, float, float]

class _Type(type):
    """The metaclass of pybind11's classes."""

class World(metaclass=_Type):
    """A Box2D world without gravity."""

    def add_walls(self, segments: Segments) -> None:
        """Each a two-sided edge, inserted in this order; Box2D's tree depends on it."""
    def add_body(self, pose: _Triple) -> int:
        """A dynamic body without fixtures; returns its index."""
    def add_circle(self, body: int, center: _Pair, radius: float) -> None: ...
    def add_polygon(self, body: int, vertices: Sequence[_Pair]) -> None: ...
    def scan(self, directions: FloatArray, pose: _Triple, range: float) -> FloatArray:
        """Ranges [m] to what rays of full length meet first, or +infinity.

        Directions are unit vectors in the lidar's frame: shape (n, 2).
        """

"""Geodesy: geodetic coordinates of a point, given east, north and up of a reference.

The Earth is the WGS 84 ellipsoid. A world's floor is the plane that touches it at the reference,
and leaves it beyond: at a distance d the altitude is about d^2 / 2 R, 8 cm after 1 km.
"""

import math
from typing import NamedTuple

# NIMA TR8350.2, "Department of Defense World Geodetic System 1984", table 3.1
_A = 6378137.0  # semi-major axis [m]
_F = 1 / 298.257223563  # flattening
_B = _A * (1 - _F)  # semi-minor axis [m]
_E2 = _F * (2 - _F)  # first eccentricity, squared
_SECOND_E2 = _E2 / (1 - _E2)  # second eccentricity, squared

_BOWRING_ITERATIONS = 2
"""One is accurate to 0.01 um within 100 km, to 6 cm anywhere; two are exact but for rounding."""


class Geodetic(NamedTuple):
    """A place on the Earth: degrees north, degrees east in [-180, 180), and metres above it."""

    latitude: float
    longitude: float
    altitude: float


class TangentPlane:
    """The plane that touches the ellipsoid at a point: x is east, y north.

    Args:
        latitude: of its origin [deg], within [-90, 90]. At a pole, north is where it would be on
            the origin's meridian just short of the pole.
        longitude: of its origin [deg], within [-180, 180].
    """

    def __init__(self, latitude: float, longitude: float) -> None:
        self._longitude = longitude
        self._sin, self._cos = math.sin(math.radians(latitude)), math.cos(math.radians(latitude))
        # The origin, off the Earth's axis and above the equator's plane.
        normal = _A / math.sqrt(1 - _E2 * self._sin**2)  # radius of curvature, east to west
        self._p, self._z = normal * self._cos, normal * (1 - _E2) * self._sin

    def to_geodetic(self, east: float, north: float) -> Geodetic:
        """The place of a point of the plane [m].

        By way of Cartesian coordinates from the Earth's centre, x through the origin's meridian:
        the ellipsoid is the same all around, so the origin's longitude is added at the end.
        """
        x = self._p - self._sin * north
        z = self._z + self._cos * north
        p = math.hypot(x, east)
        latitude = _latitude(p, z)
        sin, cos = math.sin(latitude), math.cos(latitude)
        # From p = (N + h) cos and z = (N (1 - e^2) + h) sin; without a division, for the poles.
        altitude = p * cos + z * sin - _A * math.sqrt(1 - _E2 * sin**2)
        longitude = _wrap_degrees(self._longitude + math.degrees(math.atan2(east, x)))
        return Geodetic(math.degrees(latitude), longitude, altitude)


def _latitude(p: float, z: float) -> float:
    """Geodetic latitude [rad] of a point outside the ellipsoid.

    B. R. Bowring, "Transformation from spatial to geographical coordinates", Survey Review 23
    (181), 1976, pp. 323-327: from the parametric latitude beta of the point below.

    Args:
        p: distance from the Earth's axis [m].
        z: height above the equator's plane [m].
    """
    beta = math.atan2(_A * z, _B * p)
    latitude = beta
    for _ in range(_BOWRING_ITERATIONS):
        latitude = math.atan2(
            z + _SECOND_E2 * _B * math.sin(beta) ** 3, p - _E2 * _A * math.cos(beta) ** 3
        )
        beta = math.atan2((1 - _F) * math.sin(latitude), math.cos(latitude))
    return latitude


def _wrap_degrees(longitude: float) -> float:
    """Wraps a longitude at most a turn away to [-180, 180); exact if it needs no wrapping."""
    if longitude >= 180.0:
        return longitude - 360.0
    return longitude + 360.0 if longitude < -180.0 else longitude

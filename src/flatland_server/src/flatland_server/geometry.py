"""Poses in the plane, in metres and radians; angles are counter-clockwise (REP 103)."""

import math
from typing import NamedTuple, Tuple

Point = Tuple[float, float]
"""x and y [m]."""


class Pose(NamedTuple):
    """Position [m] and heading [rad] of an inner frame relative to an outer one."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def apply(self, x: float, y: float) -> Tuple[float, float]:
        """Transforms a point from the inner frame to the outer one.

        Args:
            x: in the inner frame [m].
            y: in the inner frame [m].
        """
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + cos * x - sin * y, self.y + sin * x + cos * y

    def compose(self, inner: "Pose") -> "Pose":
        """Transforms a pose from the inner frame to the outer one.

        The yaw of the result is not wrapped: a joint compares the angles of its bodies, including
        whole revolutions.

        Args:
            inner: relative to the inner frame.
        """
        x, y = self.apply(inner.x, inner.y)
        return Pose(x, y, self.yaw + inner.yaw)

    def inverse(self) -> "Pose":
        """The pose of the outer frame relative to the inner one."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, -self.yaw)

    def wrapped(self) -> "Pose":
        """The same pose with its yaw within [-pi, pi]."""
        return Pose(self.x, self.y, wrap_angle(self.yaw))

    def is_finite(self) -> bool:
        """True if all components are finite numbers."""
        return all(math.isfinite(value) for value in self)


class Velocity(NamedTuple):
    """The velocity of a body's origin in the plane."""

    vx: float = 0.0
    """[m/s]"""
    vy: float = 0.0
    """[m/s]"""
    omega: float = 0.0
    """Counter-clockwise [rad/s]."""


class Transform(NamedTuple):
    """The pose of a frame in its parent frame at one time, for TF.

    Attributes:
        nanoseconds: the simulated time [ns].
        parent: name of the parent frame.
        child: name of the frame.
        pose: of the frame in its parent frame.
        roll: [rad]; 0, or pi for a frame that is mounted upside down.
    """

    nanoseconds: int
    parent: str
    child: str
    pose: Pose
    roll: float = 0.0


def wrap_angle(angle: float) -> float:
    """The same angle within [-pi, pi].

    Args:
        angle: [rad].
    """
    return math.remainder(angle, math.tau)


def quaternion(
    yaw: float, roll: float = 0.0, pitch: float = 0.0
) -> Tuple[float, float, float, float]:
    """The quaternion (x, y, z, w) of rotations about fixed axes (REP 103).

    Args:
        yaw: about z, after pitch [rad].
        roll: about x, first [rad].
        pitch: about y, after roll [rad].
    """
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    if roll == pitch == 0.0:
        return 0.0, 0.0, sy, cy
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )

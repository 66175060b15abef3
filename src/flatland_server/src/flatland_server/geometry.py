"""Poses in the plane: metres and radians, counter-clockwise (REP 103)."""

import math
from typing import NamedTuple, Tuple

Point = Tuple[float, float]
"""x and y [m]."""


class Pose(NamedTuple):
    """Position [m] and heading [rad] of one frame in another."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def apply(self, x: float, y: float) -> Tuple[float, float]:
        """A point of this frame, in the frame that this pose is given in."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + cos * x - sin * y, self.y + sin * x + cos * y

    def compose(self, inner: "Pose") -> "Pose":
        """The pose of `inner`, given in this frame, in the frame that this pose is given in.

        The yaws are added as they are: a joint compares its bodies' angles, whole turns included.
        """
        x, y = self.apply(inner.x, inner.y)
        return Pose(x, y, self.yaw + inner.yaw)

    def inverse(self) -> "Pose":
        """The pose of the outer frame in this one."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, -self.yaw)

    def wrapped(self) -> "Pose":
        """The same pose, its yaw within [-pi, pi]."""
        return Pose(self.x, self.y, wrap_angle(self.yaw))

    def is_finite(self) -> bool:
        """Whether no component is infinite or not a number."""
        return all(math.isfinite(value) for value in self)


class Transform(NamedTuple):
    """A frame's pose in its parent frame at one moment, for TF.

    `roll` is 0, or pi for a frame that is mounted upside down.
    """

    nanoseconds: int
    parent: str
    child: str
    pose: Pose
    roll: float = 0.0


def wrap_angle(angle: float) -> float:
    """The same angle within [-pi, pi]."""
    return math.remainder(angle, math.tau)


def quaternion(
    yaw: float, roll: float = 0.0, pitch: float = 0.0
) -> Tuple[float, float, float, float]:
    """(x, y, z, w) of turns about the fixed axes: by roll about x, pitch about y, yaw about z."""
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

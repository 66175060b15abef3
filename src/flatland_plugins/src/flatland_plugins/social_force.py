"""The social force model: how people speed up, slow down and give way.

A person of velocity v accelerates by

    dv/dt = (v0 e - v) / tau  +  sum of  A exp(-gap / B) n  +  sum of evasions

with the desired speed v0 in the desired direction e, and n away from another person, from a robot,
or from the nearest point of a wall. That is equations 1 to 3 of Helbing, Farkas and Vicsek,
"Simulating dynamical features of escape panic", Nature 407, 2000, with its constants. Its gap,
d - r1 - r2 between two discs and d - r to a wall, takes the sizes of bodies into account; its terms
for bodies that touch are left to Box2D.

These forces do not look ahead. Their evasions are those of Moussaid, Helbing, Garnier, Johansson,
Combe and Theraulaz, "Experimental study of the behavioural mechanisms underlying self-organization
in human crowds", Proc. R. Soc. B 276, 2009, with the constants that were measured there: people
turn away in time, to a preferred side, and slow down a little. Here too, distances are gaps.

Arrays hold n persons, each with m others: points and velocities (n, 2), distances (n, m), unit
vectors (n, m, 2).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple, Tuple

import numpy as np

from flatland_server import FloatArray

_VELOCITY_WEIGHT = 2.0
"""lambda [s/m]: weight of the relative velocity against the direction of the other."""

_REACTION = 0.35
"""gamma [m]: range of the evasion, per length of D."""

_NARROWNESS_OF_TURNING = 2.0
_NARROWNESS_OF_SLOWING = 3.0
"""n and n' [1/m]: narrowness of the range of angles in which the other is evaded."""


class Others(NamedTuple):
    """The surroundings of each person: distances to surfaces [m], and directions away from them."""

    distances: FloatArray
    away: FloatArray

    def nearer_by(self, radii: FloatArray) -> "Others":
        """The gaps to persons of these radii (n,)."""
        return Others(self.distances - radii[:, np.newaxis], self.away)


@dataclass(frozen=True)
class SocialForce:
    """The constants; by default those of the papers, for 80 kg.

    Attributes:
        relaxation_time: tau [s], in which a deviation from the desired velocity falls to 1/e.
        repulsion: A over the mass [m/s^2], the acceleration away from an obstacle on contact.
        range: B [m], over which the repulsion falls to 1/e.
        evasion: A of the evasions [m/s^2].
        side_preference: epsilon [rad/m], evades to the right; to the left if it is negative.
        noise: standard deviation of a walking person's velocity about the desired one [m/s], along
            each axis.
    """

    relaxation_time: float = 0.5
    repulsion: float = 2000.0 / 80.0
    range: float = 0.08
    evasion: float = 4.5
    side_preference: float = 0.005
    noise: float = 0.05

    def repel(self, gaps: Others) -> FloatArray:
        """The acceleration [m/s^2] away from others, (n, 2).

        Overlap counts as touching: separating overlapping bodies is left to Box2D.
        """
        strength = self.repulsion * np.exp(-np.maximum(gaps.distances, 0.0) / self.range)
        return np.asarray(np.einsum("nm,nmi->ni", strength, gaps.away))

    def evade(self, gaps: Others, relative_velocities: FloatArray) -> FloatArray:
        """The acceleration [m/s^2] of persons that evade others, (n, 2).

        Another person in the direction e, at the relative velocity w, is met on the course t of
        D = lambda w + e. With the angle theta from t to e, t turned left l, and b = gamma |D|,

            f = -A exp(-gap / b) (exp(-(n' b theta)^2) t + sign(theta) exp(-(n b theta)^2) l)

        where the preference epsilon b is added to theta beforehand.

        Args:
            gaps: to the others.
            relative_velocities: the persons' own less those of the others [m/s], (n, m, 2).
        """
        towards = -gaps.away
        course, length = directions(_VELOCITY_WEIGHT * relative_velocities + towards)
        range = np.maximum(_REACTION * length, 1e-9)
        left = turned_left(course)
        angle = np.arctan2((left * towards).sum(axis=-1), (course * towards).sum(axis=-1))
        angle += self.side_preference * range
        strength = self.evasion * np.exp(-np.maximum(gaps.distances, 0.0) / range)
        slow_down = strength * np.exp(-((_NARROWNESS_OF_SLOWING * range * angle) ** 2))
        turn = strength * np.exp(-((_NARROWNESS_OF_TURNING * range * angle) ** 2)) * np.sign(angle)
        forces = slow_down[..., np.newaxis] * course + turn[..., np.newaxis] * left
        return np.asarray(-forces.sum(axis=1))

    def relax(
        self, velocities: FloatArray, desired: FloatArray, accelerations: FloatArray, dt: float
    ) -> FloatArray:
        """The velocities [m/s] after `dt` [s] of the driving force and constant accelerations.

        It is the exact solution of dv/dt = (desired - v) / tau + acceleration.
        """
        end = desired + self.relaxation_time * accelerations
        return np.asarray(end + (velocities - end) * math.exp(-dt / self.relaxation_time))

    def scatter(self, numbers: FloatArray, dt: float) -> FloatArray:
        """Noise to add to velocities after `dt` [s] of `relax`, such that they scatter by `noise`.

        With the relaxation it is an Ornstein-Uhlenbeck process, whatever `dt` is.

        Args:
            numbers: normally distributed, with a standard deviation of 1.
            dt: [s].
        """
        left_over = math.exp(-2.0 * dt / self.relaxation_time)
        return self.noise * math.sqrt(1.0 - left_over) * numbers


def discs_apart(points: FloatArray, radii: FloatArray) -> Others:
    """The gaps between n discs at points (..., n, 2), each to all (..., n, n).

    A disc is infinitely far from itself.
    """
    away, distances = directions(points[..., :, np.newaxis, :] - points[..., np.newaxis, :, :])
    each = np.arange(len(radii))
    distances[..., each, each] = np.inf
    return Others(distances - radii[:, np.newaxis] - radii[np.newaxis], away)


def directions(vectors: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """Unit vectors and lengths of vectors (..., 2); the unit vector of none is zero."""
    lengths = np.hypot(vectors[..., 0], vectors[..., 1])
    return vectors / np.where(lengths > 0.0, lengths, 1.0)[..., np.newaxis], lengths


def turned_left(vectors: FloatArray) -> FloatArray:
    """Vectors (..., 2) turned by a right angle, counter-clockwise."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def limit(velocities: FloatArray, most: FloatArray) -> FloatArray:
    """Velocities (n, 2) shortened to at most these speeds (n,)."""
    unit, speeds = directions(velocities)
    return np.asarray(unit * np.minimum(speeds, most)[:, np.newaxis])

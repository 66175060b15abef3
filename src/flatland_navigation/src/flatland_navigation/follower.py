"""Follows a path by pure pursuit, and turns to a heading at its end.

Pure pursuit is that of R. Craig Coulter, "Implementation of the Pure Pursuit Path Tracking
Algorithm", CMU-RI-TR-92-01 (1992): drive on the arc that leads to a point of the path a lookahead
distance away. The lookahead distance shrinks where the straight line to that point leaves free
space, so that the robot does not cut corners.
"""

import math
from dataclasses import dataclass
from typing import Callable, NamedTuple, Tuple

import numpy as np

from flatland_server import FloatArray, Point, Pose, wrap_angle

_SPACING = 0.05  # m between points of a path
_LEAST_LOOKAHEAD = 0.15  # m
_ALIGNED = 0.2  # rad; a turn on the spot ends within this error
_TURN_GAIN = 2.0  # 1/s


class Command(NamedTuple):
    """A velocity for a robot: forwards [m/s] and counter-clockwise [rad/s]."""

    forwards: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True)
class FollowerConfig:
    """Speeds and tolerances of a path follower.

    Attributes:
        max_speed: [m/s].
        max_turn_rate: [rad/s].
        deceleration: with which the robot slows down at the end of a path and before obstacles
            [m/s^2].
        lookahead: distance to the point of the path that is pursued [m].
        turn_in_place_angle: the robot turns on the spot when that point is farther than this to
            the side [rad].
        xy_goal_tolerance: how near to the end of the path the robot must come [m].
        yaw_goal_tolerance: how near to the goal's heading the robot must come [rad].
    """

    max_speed: float = 0.5
    max_turn_rate: float = 1.5
    deceleration: float = 0.5
    lookahead: float = 0.4
    turn_in_place_angle: float = 0.8
    xy_goal_tolerance: float = 0.1
    yaw_goal_tolerance: float = 0.1


class PathFollower:
    """Follows one path.

    Args:
        path: corners [m]: shape (n, 2), n >= 2.
        heading: at the end [rad].
        config: speeds and tolerances.
        is_free: whether the straight line between two points is free.
    """

    def __init__(
        self,
        path: FloatArray,
        heading: float,
        config: FollowerConfig,
        is_free: Callable[[Point, Point], bool] = lambda start, end: True,
    ) -> None:
        self._config = config
        self._heading = heading
        self._is_free = is_free
        self._points, self._lengths = sample(path, _SPACING)
        self._index = 0  # of the last point passed
        self._turns_in_place = True  # at first: an arc might touch an obstacle next to the robot
        self._has_arrived = False

    @property
    def remaining(self) -> float:
        """Length of the path that is left [m]."""
        return float(self._lengths[-1] - self._lengths[self._index])

    def command(self, pose: Pose, period: float) -> Command:
        """The command that leads along the path.

        Args:
            pose: pose of the robot in the frame of the path.
            period: time between commands [s]; the robot is slower if that is long.
        """
        config = self._config
        self._advance(pose)
        end = self._points[-1]
        distance = math.hypot(end[0] - pose.x, end[1] - pose.y)
        self._has_arrived = distance <= config.xy_goal_tolerance * (2 if self._has_arrived else 1)
        if self._has_arrived:
            return Command(0.0, self._turn(wrap_angle(self._heading - pose.yaw), period))

        x, y = pose.inverse().apply(*self._target(pose))
        bearing = math.atan2(y, x)
        limit = _ALIGNED if self._turns_in_place else config.turn_in_place_angle
        self._turns_in_place = abs(bearing) > limit
        if self._turns_in_place:
            return Command(0.0, self._turn(bearing, period))

        curvature = pursuit_curvature(x, y)
        speed = min(
            config.max_speed,
            math.sqrt(2.0 * config.deceleration * max(distance, self.remaining)),
            config.lookahead / (4.0 * period),
            config.max_turn_rate / max(abs(curvature), 1e-9),
        )
        return Command(speed, speed * curvature)

    def is_done(self, pose: Pose) -> bool:
        """True if the robot is at the end, and has turned to the heading; after `command`."""
        error = wrap_angle(self._heading - pose.yaw)
        return self._has_arrived and abs(error) <= self._config.yaw_goal_tolerance

    def _advance(self, pose: Pose) -> None:
        """Finds the nearest point of the path ahead, not farther than the lookahead."""
        last = self._index + math.ceil(self._config.lookahead / _SPACING) + 1
        ahead = self._points[self._index : last]
        self._index += int(np.hypot(ahead[:, 0] - pose.x, ahead[:, 1] - pose.y).argmin())

    def _target(self, pose: Pose) -> Point:
        """The point to pursue: the farthest within the lookahead that a free line leads to."""
        position = pose.x, pose.y
        lookahead = self._config.lookahead
        while True:
            length = self._lengths[self._index] + lookahead
            index = min(int(np.searchsorted(self._lengths, length)), len(self._points) - 1)
            point = (float(self._points[index, 0]), float(self._points[index, 1]))
            if lookahead <= _LEAST_LOOKAHEAD or self._is_free(position, point):
                return point
            lookahead *= 0.7

    def _turn(self, error: float, period: float) -> float:
        """The rate [rad/s] that reduces an error of the heading [rad]."""
        rate = error * min(_TURN_GAIN, 0.5 / period)
        limit = self._config.max_turn_rate
        return min(max(rate, -limit), limit)


def pursuit_curvature(x: float, y: float) -> float:
    """Curvature of the arc that leads to a point, 2 y / (x^2 + y^2) [1/m] (Coulter 1992, eq. 4).

    Args:
        x: of the point in the robot's frame, forwards [m].
        y: of the point in the robot's frame, to the left [m].

    Returns:
        Positive to the left; 0 for the robot's own position.
    """
    squared = x * x + y * y
    return 2.0 * y / squared if squared > 0.0 else 0.0


def sample(path: FloatArray, spacing: float) -> Tuple[FloatArray, FloatArray]:
    """Points on a path, and their distances from its start along the path.

    Args:
        path: corners [m]: shape (n, 2), n >= 2.
        spacing: largest distance between points [m].

    Returns:
        Points with both ends, shape (m, 2), and distances, shape (m,) [m].
    """
    corners = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    count = max(2, math.ceil(corners[-1] / spacing) + 1)
    lengths = np.linspace(0.0, corners[-1], count)
    points = np.column_stack([np.interp(lengths, corners, path[:, i]) for i in range(2)])
    return points, lengths

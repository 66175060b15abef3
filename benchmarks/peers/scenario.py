"""The scenario that all simulators run: a room with discs, robots with a lidar, and commands."""

import math
from typing import Any, List, Tuple

import numpy as np

ROOM = 40.0
"""Side of the room [m]; its corner is the origin."""
DISCS = 20
DISC_RADIUS = 0.5
ROBOT_RADIUS = 0.2
BEAMS = 64
RANGE = 10.0
STEP = 0.1
"""Length of a step, after which every scan is read [s]."""
FIRST_BEAM = -math.pi
INCREMENT = 2 * math.pi / (BEAMS - 1)
"""Angle between beams [rad]. The first and the last beam both point backwards."""
SPEED = 0.5
YAW_RATE = 1.0
STEPS_PER_COMMAND = 10
_BLOCKS = 16
_TOLERANCE = 0.01
"""Tolerance of ranges [m]: ir-sim's discs are polygons of 64 corners."""
_GAP = 0.4
"""Least initial gap between robots, discs and walls [m]."""

Circle = Tuple[float, float, float]
"""x, y and radius [m]."""


class Scenario:
    """The room with some robots; the same for equal arguments.

    Args:
        robots: number of robots.
        seed: seed of the robots' places and commands.
        rooms: 1, or as many as robots: each has a room of its own, and robots may overlap.

    Attributes:
        rooms: that number.
        discs: x, y [m], shape (20, 2).
        poses: of the robots: x, y [m] and yaw [rad], shape (robots, 3).
        commands: forward velocity [m/s] and yaw rate [rad/s], shape (16, robots, 2).
    """

    def __init__(self, robots: int, seed: int, rooms: int = 1) -> None:
        self.rooms = rooms
        rng = np.random.default_rng(seed)
        taken: List[Circle] = []
        self.discs = np.array([_place(rng, DISC_RADIUS, taken) for _ in range(DISCS)])
        places = []
        for number in range(robots):
            if number % (robots // rooms) == 0:
                del taken[DISCS:]
            places.append(_place(rng, ROBOT_RADIUS, taken))
        self.poses = np.column_stack([places, rng.uniform(-math.pi, math.pi, robots)])
        low, high = (0.0, -YAW_RATE), (SPEED, YAW_RATE)
        self.commands = rng.uniform(low, high, (_BLOCKS, robots, 2))

    def wrong_share(self, ranges: Any) -> float:
        """The share of ranges that are not exact; NaN is wrong. With other robots in view, all are.

        Args:
            ranges: from the first poses [m], shape (robots, 64).
        """
        is_right = np.abs(np.array(ranges, dtype=float) - self.exact_ranges()) <= _TOLERANCE
        return float(np.mean(~is_right))

    def exact_ranges(self) -> "np.ndarray[Any, Any]":
        """Exact ranges to discs and walls, without the other robots [m]: shape (robots, 64)."""
        angles = self.poses[:, 2, None] + FIRST_BEAM + INCREMENT * np.arange(BEAMS)
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        origins = self.poses[:, None, :2]
        ranges = np.full(angles.shape, RANGE)
        for disc in self.discs:
            offset = origins - disc
            b = (offset * directions).sum(axis=-1)
            discriminant = b**2 - (offset**2).sum(axis=-1) + DISC_RADIUS**2
            distance = -b - np.sqrt(np.maximum(discriminant, 0.0))
            is_hit = (discriminant >= 0.0) & (distance >= 0.0)
            ranges = np.minimum(ranges, np.where(is_hit, distance, np.inf))
        with np.errstate(divide="ignore"):
            for axis in (0, 1):
                for wall in (0.0, ROOM):
                    distance = (wall - origins[..., axis]) / directions[..., axis]
                    ranges = np.minimum(ranges, np.where(distance >= 0.0, distance, np.inf))
        return ranges


def squares(discs: "np.ndarray[Any, Any]", side: float) -> "np.ndarray[Any, Any]":
    """The room as a map of squares, with a border of them, for simulators that have no discs.

    Args:
        discs: x, y [m], shape (n, 2).
        side: of a square [m].

    Returns:
        True where the middle of a square is in a disc, or that of a disc in a square.
    """
    count = round(ROOM / side)
    middles = (np.arange(-1, count + 1) + 0.5) * side
    found = np.ones((count + 2, count + 2), bool)
    found[1:-1, 1:-1] = False
    for x, y in discs.tolist():
        found |= (middles - x) ** 2 + (middles[:, None] - y) ** 2 <= DISC_RADIUS**2
        found[int(y // side) + 1, int(x // side) + 1] = True
    return found


def _place(rng: np.random.Generator, radius: float, taken: List[Circle]) -> Tuple[float, float]:
    """Draws a free place for a circle, and adds it to `taken`."""
    margin = radius + _GAP
    while True:
        x, y = rng.uniform(margin, ROOM - margin, 2)
        if all(math.hypot(x - a, y - b) >= radius + r + _GAP for a, b, r in taken):
            taken.append((float(x), float(y), radius))
            return float(x), float(y)

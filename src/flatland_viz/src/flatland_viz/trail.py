"""The way that a robot has gone, and where its odometry believes that it is."""

import math
from typing import List, NamedTuple, Optional, Tuple

Pose = Tuple[float, float, float]
"""x, y [m] and yaw [rad]."""

_STEP = 0.05  # m between two points
_MOST = 4000  # points
_JUMP, _FASTEST = 0.5, 5.0  # m and m/s; nothing drives further between two points


class _Point(NamedTuple):
    time: float
    x: float
    y: float


class Line:
    """A line through the places where something has been."""

    def __init__(self) -> None:
        self._points: List[_Point] = []
        self.has_changed = True

    @property
    def points(self) -> List[Tuple[float, float]]:
        """The places [m]."""
        return [(point.x, point.y) for point in self._points]

    def add(self, time: float, x: float, y: float) -> None:
        """Adds a place, if it is away from the last one. A time [s] that goes back shortens it."""
        while self._points and self._points[-1].time > time:
            self._points.pop()
            self.has_changed = True
        last = self._points[-1] if self._points else None
        distance = math.hypot(x - last.x, y - last.y) if last else math.inf
        if last and distance > _JUMP + _FASTEST * (time - last.time):
            self._points.clear()  # it was put elsewhere, as by a reset
        if distance >= _STEP:
            self._points.append(_Point(time, x, y))
            del self._points[:-_MOST]
            self.has_changed = True


class Trail:
    """The true way of a robot, and that of its odometry.

    The odometry is in a frame of its own. Its line begins where the robot was at its first message.
    """

    def __init__(self) -> None:
        self.truth = Line()
        self.belief = Line()
        self._pose: Optional[Pose] = None
        self._anchor: Optional[Tuple[Pose, Pose]] = None

    def see(self, time: float, pose: Pose) -> None:
        """Notes the true pose."""
        self._pose = pose
        self.truth.add(time, pose[0], pose[1])

    def believe(self, time: float, pose: Pose) -> None:
        """Notes where the odometry believes that the robot is."""
        if self._pose is None:
            return
        if self._anchor is None:
            self._anchor = (self._pose, pose)
        (x, y, yaw), (x0, y0, yaw0) = self._anchor
        turn = yaw - yaw0
        dx, dy = pose[0] - x0, pose[1] - y0
        self.belief.add(
            time,
            x + math.cos(turn) * dx - math.sin(turn) * dy,
            y + math.sin(turn) * dx + math.cos(turn) * dy,
        )

"""The ways that robots have gone, and where their odometry believes that they are."""

import math
from typing import Dict, List, NamedTuple, Optional, Tuple

Pose = Tuple[float, float, float]
"""x, y [m] and yaw [rad]."""

_STEP = 0.05  # m between two points
_MOST = 4000  # points
_JUMP, _FASTEST = 0.5, 5.0  # m and m/s; nothing drives further between two points


class _Point(NamedTuple):
    time: float
    x: float
    y: float


class Trail:
    """A line through the places where something has been."""

    def __init__(self) -> None:
        self._points: List[_Point] = []
        self.revision = 0
        """Changes with every change."""

    @property
    def points(self) -> List[Tuple[float, float]]:
        """The places [m]."""
        return [(point.x, point.y) for point in self._points]

    def add(self, time: float, x: float, y: float) -> None:
        """Adds a place, if it is away from the last one. A time [s] that goes back shortens it."""
        while self._points and self._points[-1].time > time:
            self._points.pop()
            self.revision += 1
        last = self._points[-1] if self._points else None
        distance = math.hypot(x - last.x, y - last.y) if last else math.inf
        if last and distance > _JUMP + _FASTEST * (time - last.time):
            self._points.clear()  # it was put elsewhere, as by a reset
        if distance >= _STEP:
            self._points.append(_Point(time, x, y))
            del self._points[:-_MOST]
            self.revision += 1


class Trails:
    """The ways of all models since `__init__`, and the belief of one robot's odometry.

    A belief is in a frame of its own. It begins where the robot was when its first message came.
    """

    def __init__(self) -> None:
        self._trails: Dict[str, Trail] = {}
        self._poses: Dict[str, Pose] = {}
        self._believer = ""
        self._belief = Trail()
        self._anchor: Optional[Tuple[Pose, Pose]] = None

    def see(self, name: str, time: float, pose: Pose) -> None:
        """Notes the true pose of a model."""
        self._poses[name] = pose
        self._trails.setdefault(name, Trail()).add(time, pose[0], pose[1])

    def of(self, name: str) -> Trail:
        """The way of a model; empty if nothing is known of it."""
        return self._trails.get(name, Trail())

    def believe(self, name: str, time: float, pose: Pose) -> None:
        """Notes where the odometry of a model believes that it is."""
        if name != self._believer:
            self._believer, self._belief, self._anchor = name, Trail(), None
        if name not in self._poses:
            return
        if self._anchor is None:
            self._anchor = (self._poses[name], pose)
        (x, y, yaw), (x0, y0, yaw0) = self._anchor
        turn = yaw - yaw0
        dx, dy = pose[0] - x0, pose[1] - y0
        self._belief.add(
            time,
            x + math.cos(turn) * dx - math.sin(turn) * dy,
            y + math.sin(turn) * dx + math.cos(turn) * dy,
        )

    def belief_of(self, name: str) -> Trail:
        """The line of a model's odometry; empty if it has none."""
        return self._belief if name == self._believer else Trail()

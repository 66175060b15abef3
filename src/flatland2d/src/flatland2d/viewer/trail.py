"""The way of a model, and the way that its odometry believes in."""

import math
from typing import Any, List, Optional, Tuple

from flatland2d.simulation import Simulation
from flatland2d.viewer.keyboard_drive import first_drive
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Point, Pose

_STEP = 0.05  # m
_MOST = 4000  # positions


class Trail:
    """Notes the positions of one model at a time.

    Args:
        simulation: has the model.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._way: List[Point] = []
        self._belief: List[Point] = []
        self._anchor: Optional[Tuple[Pose, Pose]] = None

    @property
    def lines(self) -> List[List[Point]]:
        """The true way, and that of its odometry if it has some."""
        return [line for line in (self._way, self._belief) if line]

    def clear(self) -> None:
        """Begins anew."""
        self._way, self._belief, self._anchor = [], [], None

    def note(self, model: str, reads_odometry: bool) -> None:
        """Notes where a model is, if it is away from the last position.

        Args:
            model: its name; another one than before needs `clear`.
            reads_odometry: whether its odometry is read, too, which then has to be computed.
        """
        handle = self._simulation.models.get(model)
        if handle is None:
            return
        place = handle.model.pose[:2]
        if self._way and math.dist(self._way[-1], place) < _STEP:
            return
        self._way.append(place)
        del self._way[:-_MOST]
        if reads_odometry:
            self._note_belief(handle)

    def _note_belief(self, handle: Any) -> None:
        """Odometry is in a frame of its own: it begins where the model is at its first message."""
        drive = first_drive(self._simulation, handle.name)
        try:
            estimate = handle.sensors[drive].read().pose
        except (AttributeError, KeyError, FlatlandError):
            return  # none is published, or none yet
        if self._anchor is None:
            self._anchor = (handle.model.pose, estimate)
        true, believed = self._anchor
        moved = believed.inverse().compose(estimate)
        self._belief.append(true.compose(moved)[:2])
        del self._belief[:-_MOST]

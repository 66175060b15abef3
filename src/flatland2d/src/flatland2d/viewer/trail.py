"""The way of a model, and the way that its odometry believes in."""

from typing import Any, List

from flatland2d.simulation import Simulation
from flatland2d.viewer.keyboard_drive import first_drive
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Point
from flatland_teleop.trails import Trails


class Trail:
    """Notes the positions of one model at a time.

    Args:
        simulation: has the model.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._model = ""
        self.clear()

    @property
    def lines(self) -> List[List[Point]]:
        """The true way, and that of its odometry if it has some."""
        trails = self._trails.of(self._model), self._trails.belief_of(self._model)
        return [trail.points for trail in trails if trail.points]

    def clear(self) -> None:
        """Begins anew."""
        self._trails = Trails()

    def note(self, model: str, reads_odometry: bool) -> None:
        """Notes where a model is, if it is away from the last position.

        Args:
            model: its name; another one than before needs `clear`.
            reads_odometry: whether its odometry is read, too, which then has to be computed.
        """
        handle = self._simulation.models.get(model)
        if handle is None:
            return
        self._model = model
        before = self._trails.of(model).revision
        self._trails.see(model, self._simulation.time, handle.model.pose)
        if reads_odometry and self._trails.of(model).revision != before:
            self._note_belief(handle)

    def _note_belief(self, handle: Any) -> None:
        drive = first_drive(self._simulation, handle.name)
        try:
            estimate = handle.sensors[drive].read().pose
        except (AttributeError, KeyError, FlatlandError):
            return  # none is published, or none yet
        self._trails.believe(handle.name, self._simulation.time, estimate)

"""The timeline of the window: the moments of a run, and where it is."""

from flatland2d.simulation import Simulation
from flatland_server.exceptions import StateError
from flatland_server.simulation.history import SHARE_OF_VIEWERS


class Timeline:
    """Keeps the history of a simulation, and goes to its moments.

    Args:
        simulation: is shown; it may have a history already.
        keeps: whether to keep one otherwise.
    """

    def __init__(self, simulation: Simulation, keeps: bool = True) -> None:
        self._simulation = simulation
        self.problem = ""
        """The reason why there is no history; empty if there is one."""
        if keeps and simulation.history is None:
            try:
                simulation.keep_history(share=SHARE_OF_VIEWERS)
            except StateError as error:
                self.problem = str(error)

    @property
    def begin(self) -> float:
        """The first moment [s]."""
        history = self._simulation.history
        return history.begin if history is not None else self._simulation.time

    @property
    def end(self) -> float:
        """The last moment [s]."""
        history = self._simulation.history
        return history.end if history is not None else self._simulation.time

    @property
    def is_in_past(self) -> bool:
        """True if there are later moments than the one that is shown."""
        history = self._simulation.history
        return history is not None and history.is_in_past

    @property
    def fraction(self) -> float:
        """The part of the run that is before the moment that is shown: 0 to 1."""
        length = self.end - self.begin
        return (self._simulation.time - self.begin) / length if length > 0 else 1.0

    def time_at(self, fraction: float) -> float:
        """The time of a part of the run [s]; the reverse of `fraction`."""
        return self.begin + min(max(fraction, 0.0), 1.0) * (self.end - self.begin)

    def seek(self, time: float) -> None:
        """Shows the moment at a time [s], or the first or last one.

        Raises:
            FlatlandError: there is no history.
        """
        self._simulation.seek(min(max(time, self.begin), self.end))

"""A run that keeps its history, and goes back to any moment of it."""

from typing import Optional, TypeVar

from flatland_server.exceptions import UsageError
from flatland_server.simulation.history import History
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper

R = TypeVar("R", bound="RunWithHistory")


class RunWithHistory(Run):
    """A run in which time can be sought, once it keeps states; until then it is as any other.

    Args:
        world: as for `Run`.
        timekeeper: as for `Run`.
        raise_failures: as for `Run`.
    """

    def __init__(
        self, world: World, timekeeper: Timekeeper, *, raise_failures: bool = False
    ) -> None:
        super().__init__(world, timekeeper, raise_failures=raise_failures)
        self._history: Optional[History] = None

    @property
    def history(self) -> Optional[History]:
        """The states that are kept for `seek`, if any."""
        return self._history if self._history is not None and self._history.is_open else None

    def keep_history(
        self, interval: float = 1.0, memory: int = 64_000_000, share: float = 1.0
    ) -> History:
        """Begins to keep states of the run as it goes, for `seek`; replaces a former history.

        Args:
            interval: as for `History`.
            memory: as for `History`.
            share: as for `History`.
        """
        self.require_open()
        history = History(self, interval, memory, share)
        if self.history is not None:
            self.history.close()
        self._history = history
        return history

    def seek(self: R, time: float) -> R:
        """Puts the run into its state at another time, bit for bit, and returns this run.

        Once it goes on from there, what came later is forgotten. See `load_state`.

        Args:
            time: since `keep_history` was called [s]; the nearest step.

        Raises:
            FlatlandError: the history does not have this time, or a step is being made.
        """
        self.require_open()
        self.world.require_between_steps("seek")
        if self.history is None:
            raise UsageError("expected keep_history() before the steps to which seek goes back")
        self.history.seek(time)
        return self

    def close(self) -> None:
        """Stops all plugins. Later calls raise a UsageError; poses may still be read."""
        if self.history is not None:
            self.history.close()
        super().close()

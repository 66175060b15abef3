"""A rate slower than the simulation's."""

import math

from flatland_server.timekeeper import Timekeeper


class UpdateTimer:
    """Says when something that has a rate of its own is due, in simulated time.

    It is due at the first check and then at multiples of its period from there: a period that is no
    multiple of the step is kept on average, without drift.

    Args:
        rate: [Hz] above zero; infinity is due at every check.
    """

    def __init__(self, rate: float = math.inf) -> None:
        if not rate > 0:
            raise ValueError(f"expected a rate above 0 Hz, found {rate}")
        self._period = 1e9 / rate  # ns
        self._start = 0
        self.due: float = -1
        """The time [ns] from which on the next check says yes."""

    @property
    def period(self) -> float:
        """Time between two updates [s]; 0 for an infinite rate."""
        return self._period * 1e-9

    def check_update(self, timekeeper: Timekeeper) -> bool:
        """Whether an update is due now. True only once for each."""
        now = timekeeper.nanoseconds
        if now < self.due:
            return False
        if self.due < 0:
            self._start = now
        if math.isinf(self._period):
            self.due = math.inf
        elif self._period > 0:
            passed = round(math.floor((now - self._start + 0.5) / self._period) + 1)
            self.due = self._start + round(passed * self._period)
        return True

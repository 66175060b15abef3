"""Updates at a rate slower than that of the simulation's steps."""

import math
from typing import Any, Dict

import numpy as np

from flatland_server.arrays import FloatArray, IntArray
from flatland_server.timekeeper import Timekeeper

_LONGEST = 1e18
"""The longest period, 32 years [ns]: that of a lower rate would be infinite, or nearly so."""


class UpdateTimer:
    """Tells when an update is due, in simulated time.

    The first update is due at the first check, further ones at multiples of the period after it. A
    period that is not a multiple of the step is kept on average, without drift.

    Args:
        rate: of updates [Hz], above zero; with infinity, one is due at every check.

    Raises:
        ValueError: the rate is not above zero.
    """

    def __init__(self, rate: float = math.inf) -> None:
        if not rate > 0:
            raise ValueError(f"expected a rate above 0 Hz, found {rate}")
        self._period = min(1e9 / rate, _LONGEST)  # ns
        self._start = 0
        self.due: float = -1
        """The simulated time [ns] from which on an update is due; -1 for any time."""

    @property
    def period(self) -> float:
        """Time between two updates [s]; 0 for an infinite rate."""
        return self._period * 1e-9

    def check_update(self, timekeeper: Timekeeper) -> bool:
        """True if an update is due now; true once for each update.

        Args:
            timekeeper: the simulated time.
        """
        return self.check_update_at(timekeeper.nanoseconds)

    def check_update_at(self, now: int) -> bool:
        """True if an update is due at a time; see `check_update`.

        The next one is due as if the steps since the last check had all been checked.

        Args:
            now: simulated time [ns].
        """
        if now < self.due:
            return False
        if self.due < 0:
            self._start = now
        if self._period > 0:
            passed = round(math.floor((now - self._start + 0.5) / self._period) + 1)
            self.due = self._start + round(passed * self._period)
        return True

    def get_state(self) -> Dict[str, Any]:
        """Its period and due time, for the state of a plugin that has a timer of its own.

        The framework itself keeps that of `Plugin.update_timer`.
        """
        return {"period": self._period, "start": self._start, "due": self.due}

    def set_state(self, state: Dict[str, Any]) -> None:
        """Restores a state.

        Args:
            state: result of `get_state`.

        Raises:
            ValueError: it is not the state of a timer.
        """
        period, start, due = (state[key] for key in ("period", "start", "due"))
        if not (
            all(isinstance(each, (int, float)) for each in (period, start, due))
            and 0.0 <= period <= _LONGEST
            and math.isfinite(start)
            and due >= -1.0
        ):
            raise ValueError(f"expected the state of a timer, found {state}")
        self._period, self._start, self.due = period, start, due


def due_after(times: IntArray, rate: float) -> FloatArray:
    """The due times of the next updates after some times [ns], in many environments at once.

    The same numbers as those of an `UpdateTimer` that started at time 0. Its own formula is without
    NumPy, which takes ten times as long for one number.

    Args:
        times: of updates that were due [ns], shape (n,).
        rate: of updates [Hz], above zero; with infinity, one is due at every check.
    """
    period = min(1e9 / rate, _LONGEST)
    if period == 0.0:
        return times.astype(np.float64)
    due: FloatArray = np.rint((np.floor((times + 0.5) / period) + 1.0) * period)
    return due

"""Periods of real time, for work that goes on while the simulation is paused."""

import time


class RealTimeTimer:
    """Is due at once, and then periodically.

    Args:
        period: [s] of real time. Periods missed since the last check are skipped.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._due = 0.0

    def check_update(self) -> bool:
        """True if it is due now; true only once per period."""
        now = time.monotonic()
        if now < self._due:
            return False
        self._due += self._period
        if self._due <= now:
            self._due = now + self._period
        return True

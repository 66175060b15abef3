"""Rates of real time, for what goes on in a pause too."""

import time


class RealTimeTimer:
    """Says when something is due: at once, and then again and again.

    Args:
        period: [s] of real time. Who asks too late for one time hears of it once, not twice.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._due = 0.0

    def check_update(self) -> bool:
        """Whether it is due now. True only once for each time."""
        now = time.monotonic()
        if now < self._due:
            return False
        self._due += self._period
        if self._due <= now:
            self._due = now + self._period
        return True

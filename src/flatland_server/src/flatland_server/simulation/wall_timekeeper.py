"""Simulated time with stamps of real time: messages look like those of a real robot."""

import time
from typing import Callable

from flatland_server.messages.conversions import set_stamp_offset, stamp_offset
from flatland_server.simulation.pacer import Pacer
from flatland_server.timekeeper import Timekeeper

_TOLERANCE = 10_000_000
"""A smaller lag is left alone, so that the stamps of steps are a step apart [ns]."""


class WallTimekeeper(Timekeeper):
    """Counts simulated time from 0, as any other, and sets the stamps of the process.

    Only stamps differ: noise, timers, states and the history depend on simulated time. Stamps never
    go back, neither when simulated time does nor when the real clock is set back.

    Args:
        step_size: length of a step [s]; rounded to whole nanoseconds.
        clock: returns the real time [ns].

    Raises:
        UsageError: as of `Timekeeper`.
    """

    def __init__(self, step_size: float, clock: Callable[[], int] = time.time_ns) -> None:
        super().__init__(step_size)
        self._clock = clock
        set_stamp_offset(clock())

    def follow(self, lateness: float = 0.0) -> None:
        """Advances the stamps to real time if they lag behind it, as in a pause.

        Args:
            lateness: real time since the step was due [s].
        """
        present = self._clock() - round(lateness * 1e9)
        if present - self.nanoseconds - stamp_offset() > _TOLERANCE:
            set_stamp_offset(present - self.nanoseconds)

    def jump_to(self, nanoseconds: int) -> None:
        """Sets simulated time; stamps go on.

        Args:
            nanoseconds: as of `Timekeeper`.
        """
        set_stamp_offset(stamp_offset() + self.nanoseconds - nanoseconds)
        super().jump_to(nanoseconds)
        self.follow()


class WallPacer(Pacer):
    """A pacer that brings the stamps up to date before each step, and during a pause.

    Args:
        timekeeper: timekeeper with the stamps.
        clock: returns the real time [s], as of `Pacer`.
    """

    def __init__(self, timekeeper: WallTimekeeper, clock: Callable[[], float]) -> None:
        super().__init__(clock)
        self._timekeeper = timekeeper

    def begin_step(self, is_paused: bool) -> bool:
        """True if a step is to be made now; steps that are requested have no due time."""
        is_due = super().begin_step(is_paused)
        if is_due or is_paused:
            self._timekeeper.follow(self.lateness if is_due else 0.0)
        return is_due

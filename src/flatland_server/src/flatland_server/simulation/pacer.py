"""Paces steps at a rate of real time: when the next one is due, and how late steps are."""

import time
from collections import deque
from typing import Callable, Deque, List, Tuple

from flatland_server.messages.conversions import set_stamp_offset, stamp_offset
from flatland_server.timekeeper import Timekeeper

_MAX_BACKLOG = 0.25
"""The longest delay that steps without a wait catch up [s]; the excess is given up."""

_MAX_TICK_PERIOD = 0.02
"""The longest wait before the next tick [s]; also the period of ticks during a pause."""

_MIN_TICK_PERIOD = 0.001
"""Time between ticks while steps follow each other without a wait [s]."""

_MAX_STEP_STARTS = 1001
"""The number of step start times kept for jitter statistics."""

_METERING_PERIOD = 1.0
"""Real time over which the real-time factor is measured [s]."""

_TOLERANCE = 10_000_000
"""A smaller lag is left alone, so that the stamps of steps are a step apart [ns]."""


class Pacer:
    """The schedule of a simulation's loop: wait, make a step if one is due, tick if one is due.

    Steps are due one period after the other, however long each of them takes. If they are late, the
    next ones follow without a wait until the delay is caught up, or given up if it is too long.

    In a tick, other work is done, such as publishing a state. It is due before each wait, and every
    millisecond while there are no waits.

        pacer.start(simulated_time)
        while True:
            wait(pacer.wait_time)
            if pacer.begin_step(is_paused):
                ...
            if pacer.end_step(period, is_paused):  # a tick is due
                ...
                pacer.end_tick(simulated_time)

    Args:
        clock: returns the real time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.real_time_factor = 0.0
        """Simulated time per real time, in the last second or so."""
        self._clock = clock
        self._now = 0.0  # the clock's time when it was last read
        self._due = 0.0  # the time of the next step
        self._last_due = 0.0  # the time of the last step, from which the next one is counted
        self._tick_due = 0.0
        self._metered: Tuple[float, float] = (0.0, 0.0)  # real and simulated time [s]
        self._step_starts: Deque[float] = deque(maxlen=_MAX_STEP_STARTS)

    @property
    def step_periods(self) -> List[float]:
        """Real time from the start of each of the latest steps to the next, since a pause [s]."""
        starts = list(self._step_starts)
        return [later - earlier for earlier, later in zip(starts, starts[1:])]

    @property
    def lateness(self) -> float:
        """Real time since the present step was due [s]."""
        return self._clock() - self._last_due

    def start(self, simulated_time: float) -> None:
        """Begins a run: the first step is due now.

        Args:
            simulated_time: since the start of the simulation [s].
        """
        self._now = self._due = self._last_due = self._tick_due = self._clock()
        self._metered = (self._now, simulated_time)

    @property
    def wait_time(self) -> float:
        """Time until the next step or tick [s]; 0 if a step is due already."""
        wait = self._due - self._now
        if wait <= 0.0:
            return 0.0
        return wait if wait < _MAX_TICK_PERIOD else _MAX_TICK_PERIOD

    def begin_step(self, is_paused: bool) -> bool:
        """True if a step is to be made now; never during a pause."""
        if self._now < self._due:
            self._now = self._clock()
            if self._now < self._due:
                return False
        oldest = self._now - _MAX_BACKLOG
        self._last_due = self._due if self._due > oldest else oldest
        if is_paused:
            self._step_starts.clear()
            return False
        self._step_starts.append(self._now)
        return True

    def skip_step(self) -> None:
        """Gives up a step that was to be made now: it is not caught up."""
        self._last_due = self._now

    def end_step(self, period: float, is_paused: bool) -> bool:
        """Schedules the next step, also if none was due. Returns whether it is time for a tick.

        Args:
            period: of the steps [s]; may change at any time.
            is_paused: whether steps are due no more often than ticks, however short the period is.
        """
        self._due = self._last_due + (max(period, _MAX_TICK_PERIOD) if is_paused else period)
        now = self._now = self._clock()
        return now < self._due or now >= self._tick_due

    def end_tick(self, simulated_time: float) -> None:
        """Schedules the next tick, and measures the real-time factor from time to time.

        Args:
            simulated_time: since the start of the simulation [s].
        """
        self._now = self._clock()
        self._tick_due = self._now + _MIN_TICK_PERIOD
        real, simulated = self._metered
        if self._now - real >= _METERING_PERIOD:
            self.real_time_factor = (simulated_time - simulated) / (self._now - real)
            self._metered = (self._now, simulated_time)


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

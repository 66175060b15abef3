"""Maps real time to simulated time: rate, pause and single steps."""

import math
from typing import Callable, List, Tuple

RATES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""The rates that `faster` and `slower` choose from: simulated seconds per second."""

_LONGEST_FRAME = 0.25
"""The longest frame that is simulated completely [s of real time]; the excess is dropped."""

_METERING_PERIOD = 0.5
"""Real time over which the rate is measured [s]."""

_EPSILON = 1e-9


class Playback:
    """Makes the steps that are due, and measures their rate.

    Args:
        rate: simulated seconds per second of real time.
    """

    def __init__(self, rate: float = 1.0) -> None:
        self.rate = rate
        self.is_paused = False
        self.measured_rate = 0.0
        """Simulated time per real time, in the last half second or so."""
        self._backlog = 0.0  # simulated time that is due [s]
        self._metered: Tuple[float, float] = (0.0, 0.0)  # real and simulated time [s]

    def faster(self) -> None:
        """Chooses the next higher rate."""
        self.rate = next((rate for rate in RATES if rate > self.rate + _EPSILON), self.rate)

    def slower(self) -> None:
        """Chooses the next lower rate."""
        lower: List[float] = [rate for rate in RATES if rate < self.rate - _EPSILON]
        self.rate = lower[-1] if lower else self.rate

    def advance(
        self,
        elapsed: float,
        step_size: float,
        step: Callable[[], None],
        is_time_up: Callable[[], bool],
    ) -> None:
        """Makes the steps that are due.

        Args:
            elapsed: real time since the last call [s].
            step_size: of a step [s].
            step: makes one.
            is_time_up: whether no more steps can be made in this frame; those that are still due
                are left out, so that the window stays responsive.
        """
        if self.is_paused:
            self._backlog = 0.0
            self._meter(elapsed, 0.0)
            return
        self._backlog += min(elapsed, _LONGEST_FRAME) * self.rate
        due = math.floor(self._backlog / step_size + _EPSILON)
        made = 0
        while made < due and not is_time_up():
            step()
            made += 1
        self._backlog = self._backlog - made * step_size if made == due else 0.0
        self._meter(elapsed, made * step_size)

    def _meter(self, real: float, simulated: float) -> None:
        real, simulated = self._metered[0] + real, self._metered[1] + simulated
        if real >= _METERING_PERIOD:
            self.measured_rate = simulated / real
            real = simulated = 0.0
        self._metered = (real, simulated)

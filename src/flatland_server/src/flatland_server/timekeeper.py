"""Simulated time."""

from typing import Final

from flatland_server.exceptions import UsageError, shortened

LONGEST_STEP = 1000.0  # s; the shortest is a nanosecond


class Timekeeper:
    """Counts simulated time in whole nanoseconds, so that it is exact and the same in every run.

    Args:
        step_size: length of a step [s]; rounded to whole nanoseconds.

    Attributes:
        nanoseconds: simulated time since the start [ns]; set by the world alone.
        step_nanoseconds: length of a step [ns].
        step_size: length of a step [s].

    Raises:
        UsageError: the step is shorter than a nanosecond, or longer than 1000 s, or no number.
    """

    def __init__(self, step_size: float) -> None:
        try:
            nanoseconds = round(float(step_size) * 1e9)
        except (TypeError, OverflowError, ValueError):
            nanoseconds = 0
        if not 1 <= nanoseconds <= LONGEST_STEP * 1e9:
            found = shortened(repr(step_size))
            raise UsageError(f"expected a step of 1e-9 to {LONGEST_STEP:g} s, found {found}")
        self.nanoseconds = 0
        self.step_nanoseconds: Final = nanoseconds
        self.step_size: Final = nanoseconds * 1e-9

    @property
    def seconds(self) -> float:
        """Simulated time since the start [s]."""
        return self.nanoseconds * 1e-9

    def step(self, count: int = 1) -> None:
        """Advances simulated time.

        Args:
            count: number of steps.
        """
        self.nanoseconds += count * self.step_nanoseconds

    def jump_to(self, nanoseconds: int) -> None:
        """Sets simulated time.

        Args:
            nanoseconds: 0 at a reset, another time when a state is loaded [ns].
        """
        self.nanoseconds = nanoseconds

"""Simulated time."""

LONGEST_STEP = 1000.0  # s; the shortest is a nanosecond


class Timekeeper:
    """Counts simulated time in whole nanoseconds, so that it is exact and the same in every run.

    Args:
        step_size: length of a step [s]; rounded to whole nanoseconds.

    Raises:
        ValueError: the step is shorter than a nanosecond, or longer than 1000 s.
    """

    def __init__(self, step_size: float) -> None:
        try:
            self._step_nanoseconds = round(step_size * 1e9)
        except (OverflowError, ValueError):
            self._step_nanoseconds = 0
        if self._step_nanoseconds < 1 or step_size > LONGEST_STEP:
            raise ValueError(f"expected a step of 1e-9 to {LONGEST_STEP:g} s, found {step_size}")
        self._nanoseconds = 0

    @property
    def nanoseconds(self) -> int:
        """Simulated time since the start [ns]."""
        return self._nanoseconds

    @property
    def seconds(self) -> float:
        """Simulated time since the start [s]."""
        return self._nanoseconds * 1e-9

    @property
    def step_nanoseconds(self) -> int:
        """Length of a step [ns]."""
        return self._step_nanoseconds

    @property
    def step_size(self) -> float:
        """Length of a step [s]."""
        return self._step_nanoseconds * 1e-9

    def step(self, count: int = 1) -> None:
        """Advances simulated time by one step, or by several."""
        self._nanoseconds += count * self._step_nanoseconds

    def jump_to(self, nanoseconds: int) -> None:
        """Sets simulated time [ns]: to 0 at a reset, to another time when a state is loaded."""
        self._nanoseconds = nanoseconds

"""The progress of a training, the bar that shows it, and its end by Ctrl-C."""

import math
from typing import NamedTuple

from flatland2d import MissingPackageError
from flatland_gym.policy import Policy

_BAR = "{l_bar}{bar}| {n:.0f}/{total:.0f} {unit} [{elapsed}<{remaining}{postfix}]"


class Progress(NamedTuple):
    """The state of a training, after an update."""

    steps: int
    """Environment steps so far, over all environments."""
    seconds: float
    """Time since the beginning [s]."""
    episodes: int
    """Number of episodes that have ended since the last update."""
    success: float
    """The fraction of these episodes that reached the goal; NaN without any."""
    reward: float
    """The mean return of these episodes; NaN without any."""


class TrainingInterrupted(KeyboardInterrupt):
    """Ctrl-C during a training.

    Args:
        policy: as it was then.
    """

    def __init__(self, policy: Policy) -> None:
        super().__init__()
        self.policy = policy


class TrainingBar:
    """A bar of tqdm, for a terminal or a notebook: of the time, or of the steps without a limit.

    Args:
        steps: to train at most.
        seconds: to train at most.

    Raises:
        MissingPackageError: tqdm is not installed.
    """

    def __init__(self, steps: int, seconds: float) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            raise MissingPackageError("a progress bar needs tqdm: pip install tqdm") from None
        self._is_timed = seconds < math.inf
        self._bar = tqdm(
            total=seconds if self._is_timed else steps,
            unit="s" if self._is_timed else "steps",
            bar_format=_BAR,
        )

    def show(self, now: Progress) -> None:
        """Shows the progress."""
        bar = self._bar
        bar.set_postfix_str(f"{now.steps} steps, success {now.success:.1%}", refresh=False)
        bar.update(min(now.seconds if self._is_timed else now.steps, bar.total) - bar.n)

    def close(self) -> None:
        """Leaves the bar as it is."""
        self._bar.close()

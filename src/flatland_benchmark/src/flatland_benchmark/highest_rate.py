"""The search for the highest rate of a simulation at which a subscriber gets every message."""

import math
from typing import Callable, Optional

MEASURING = 10.0
"""Real time for which no message may be missing [s]."""

_PRECISION = 1.05
"""Ratio of the least rate that is too high to the one that is found."""

_FIRST = 1.0
_LEAST_SHARE = 0.97
"""Of a rate, which the simulation must reach for it to count."""


def highest_rate(reached: Callable[[float], Optional[float]]) -> float:
    """Finds the rate by bisection.

    Args:
        reached: runs at a rate [times real time], which may be infinite; returns the measured one,
            or None if a message is missing.

    Returns:
        The measured rate [times real time]; 0 if messages are missing in real time.
    """
    unlimited = reached(math.inf)
    if unlimited is not None:
        return unlimited
    best, low, high = 0.0, _FIRST, _FIRST
    while True:  # the first rate that is too high
        measured = _sustained(reached, high)
        if measured is None:
            break
        best, low, high = measured, high, 4.0 * high
    while best and high > _PRECISION * low:
        middle = math.sqrt(low * high)
        measured = _sustained(reached, middle)
        if measured is None:
            high = middle
        else:
            best, low = measured, middle
    return best


def _sustained(reached: Callable[[float], Optional[float]], rate: float) -> Optional[float]:
    measured = reached(rate)
    return measured if measured is not None and measured >= _LEAST_SHARE * rate else None

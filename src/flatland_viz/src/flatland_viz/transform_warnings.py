"""Warnings of rviz's transforms: printed once, and counted."""

import ctypes
import itertools
from typing import Dict, NamedTuple

from flatland_viz.native import library

_LENGTH = 501
"""Bytes of the longest text, and its final zero."""
_LEAST = 20
"""The number of warnings that is reported first: a few come when simulated time begins again."""
_EXPIRY = 10.0  # s of real time


def print_warnings_once() -> None:
    """Counts tf2's warnings from now on."""
    library().flatland_viz_print_warnings_once()


def take_warnings() -> Dict[str, int]:
    """The number of times that each warning has come since the last call, by its text."""
    taken: Dict[str, int] = {}
    text = ctypes.create_string_buffer(_LENGTH)
    for number in itertools.count():
        times = library().flatland_viz_take_warning(number, text, _LENGTH)
        if times < 0:
            break
        if times:
            taken[text.value.decode(errors="replace")] = times
    return taken


class _Warning(NamedTuple):
    times: int
    came_at: float


class TransformWarnings:
    """Counts warnings, and decides which are worth a report."""

    def __init__(self) -> None:
        self._warnings: Dict[str, _Warning] = {}

    def update(self, new: Dict[str, int], now: float) -> Dict[str, int]:
        """Counts new warnings.

        Args:
            new: how often each has come since the last call, by its text.
            now: real time [s].

        Returns:
            How often each has come, by its text: of those that have come some times, and not long
            ago.
        """
        for text, times in new.items():
            before = self._warnings.get(text, _Warning(0, now))
            self._warnings[text] = _Warning(before.times + times, now)
        for text, warning in list(self._warnings.items()):
            if now - warning.came_at > _EXPIRY:
                del self._warnings[text]
        counts = {text: warning.times for text, warning in self._warnings.items()}
        return {text: count for text, count in counts.items() if count >= _LEAST}

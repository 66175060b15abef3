"""Warnings of rviz's transforms: printed once, and counted."""

import ctypes
import itertools
from contextlib import suppress
from typing import Dict, List, NamedTuple, Tuple

_LIBRARY = "libflatland_viz_tools.so"
_LENGTH = 501
"""Bytes of the longest text, and its final zero."""
_LEAST = 20
"""The number of warnings that is reported first: a few come when simulated time begins again."""
_EXPIRY = 10.0  # s of real time


def print_warnings_once() -> None:
    """Counts tf2's warnings from now on. Without our library, which is logged elsewhere, none."""
    with suppress(OSError):
        ctypes.CDLL(_LIBRARY).flatland_viz_print_warnings_once()


def take_warnings() -> Dict[str, int]:
    """The number of times that each warning has come since the last call, by its text."""
    taken: Dict[str, int] = {}
    with suppress(OSError):
        take = ctypes.CDLL(_LIBRARY).flatland_viz_take_warning
        text = ctypes.create_string_buffer(_LENGTH)
        for number in itertools.count():
            times = take(number, text, _LENGTH)
            if times < 0:
                break
            if times:
                taken[text.value.decode(errors="replace")] = times
    return taken


class _Warning(NamedTuple):
    unreported: int
    is_reported: bool
    came_at: float


class TransformWarnings:
    """Decides which warnings are worth a report."""

    def __init__(self) -> None:
        self._warnings: Dict[str, _Warning] = {}

    def update(self, new: Dict[str, int], now: float) -> Tuple[Dict[str, int], List[str]]:
        """Counts new warnings.

        Args:
            new: how often each has come since the last call, by its text.
            now: real time [s].

        Returns:
            The numbers to report, by text: of warnings that have come some times. And the texts
            that come no more, each once.
        """
        due: Dict[str, int] = {}
        for text, times in new.items():
            before = self._warnings.get(text, _Warning(0, False, now))
            count = before.unreported + times
            is_due = before.is_reported or count >= _LEAST
            if is_due:
                due[text] = count
            self._warnings[text] = _Warning(0 if is_due else count, is_due, now)
        ended = [text for text, each in self._warnings.items() if now - each.came_at > _EXPIRY]
        for text in ended:
            del self._warnings[text]
        return due, ended

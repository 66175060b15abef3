"""Warnings of rviz's transforms: printed once, and counted."""

import ctypes
import threading
import time
from contextlib import suppress
from typing import Callable, Dict, List, NamedTuple, Optional

_LIBRARY = "libflatland_viz_tools.so"
_LEAST = 20
"""The number of warnings that is reported first: a few come when simulated time begins again."""
_REPORT_PERIOD = 1.0  # s of real time
_EXPIRY = 10.0  # s of real time


class _Warning(NamedTuple):
    unreported: int
    reported_at: Optional[float]
    came_at: float


class TransformWarnings:
    """Counts warnings from `start` on.

    Args:
        report: called with a text and how often it has come since the last call, once it has come
            some times, and once a second at most, on any thread.
    """

    def __init__(self, report: Callable[[str, int], None]) -> None:
        self._report = report
        self._lock = threading.Lock()
        self._warnings: Dict[str, _Warning] = {}
        self._callback = ctypes.CFUNCTYPE(None, ctypes.c_char_p)(self._receive)

    def start(self) -> None:
        """Takes tf2's warnings. Without our library, which is logged elsewhere, none come."""
        with suppress(OSError):
            ctypes.CDLL(_LIBRARY).flatland_viz_print_warnings_once(self._callback)

    def _receive(self, text: bytes) -> None:
        self.note(text.decode(errors="replace"), time.monotonic())

    def note(self, text: str, now: float) -> None:
        """Counts a warning that has come now [s]."""
        with self._lock:
            before = self._warnings.get(text, _Warning(0, None, now))
            count = before.unreported + 1
            if before.reported_at is None:
                is_due = count >= _LEAST
            else:
                is_due = now - before.reported_at >= _REPORT_PERIOD
            self._warnings[text] = _Warning(
                0 if is_due else count, now if is_due else before.reported_at, now
            )
        if is_due:
            self._report(text, count)

    def expired(self) -> List[str]:
        """The texts that come no more, each once."""
        now = time.monotonic()
        with self._lock:
            texts = [text for text, each in self._warnings.items() if now - each.came_at > _EXPIRY]
            for text in texts:
                del self._warnings[text]
        return texts

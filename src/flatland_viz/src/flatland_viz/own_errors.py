"""Errors of the window itself, such as in a callback: logged once each, and counted."""

import logging
import threading
from typing import Dict, List, Tuple

_LOGGER = "rosout"
_TRACEBACK = "Traceback (most recent call last):"
_PLACE = 'File "'


class OwnErrors(logging.Filter):
    """Counts the errors that rospy logs with a traceback, from `start` on.

    rospy logs those of its callbacks, and the program those of Qt's slots and of threads. A
    callback that fails does so with each message, hundreds of times a second; an error is the same
    if its traceback leads through the same lines.
    """

    def __init__(self) -> None:
        super().__init__()
        self._lock = threading.Lock()
        self._texts: Dict[Tuple[str, ...], str] = {}  # by the lines of the traceback
        self._counts: Dict[str, int] = {}  # since the last `take`, by text

    def start(self) -> None:
        """Takes part in rospy's log."""
        logging.getLogger(_LOGGER).addFilter(self)

    def filter(self, record: logging.LogRecord) -> bool:
        """Counts an error. Returns whether to log the record."""
        text = record.getMessage()
        if record.levelno < logging.ERROR or _TRACEBACK not in text:
            return True
        lines = [line.strip() for line in text.splitlines()]
        place = tuple(line for line in lines if line.startswith(_PLACE))
        with self._lock:
            is_new = place not in self._texts
            text = self._texts.setdefault(place, text)
            self._counts[text] = self._counts.get(text, 0) + 1
        return is_new

    def take(self) -> List[Tuple[str, int]]:
        """The errors since the last call, and how often each came."""
        with self._lock:
            counts, self._counts = self._counts, {}
        return list(counts.items())

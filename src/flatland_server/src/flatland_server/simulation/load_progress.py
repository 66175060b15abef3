"""The progress of loading a large world: lines in the log, which the server also publishes."""

import logging
import time

logger = logging.getLogger(__name__)

_DELAY = 2.0  # s: a world that is loaded sooner needs no report
_STEP = 10  # percent


class LoadProgress:
    """Logs how many walls of a world have been added, in steps of 10 %, once that takes long.

    The records have an attribute `percent`; the last one is 100.

    Args:
        walls: the number of walls of all layers.
        delay: seconds of real time until the first record.
    """

    def __init__(self, walls: int, delay: float = _DELAY) -> None:
        self._walls = walls
        self._former_layers = 0
        self._due = time.monotonic() + delay
        self._next = _STEP

    def update(self, added: int) -> None:
        """Logs the progress if that is due.

        Args:
            added: walls of the present layer that have been added.
        """
        percent = 100 * (self._former_layers + added) // self._walls
        if percent < self._next or (time.monotonic() < self._due and self._next == _STEP):
            return
        self._next = percent - percent % _STEP + _STEP
        logger.info("walls: %d %%", percent, extra={"percent": percent})

    def layer_is_complete(self, walls: int) -> None:
        """Counts a layer with this number of walls as added."""
        self._former_layers += walls

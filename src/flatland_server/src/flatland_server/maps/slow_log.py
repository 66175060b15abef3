"""Log messages for operations that can be slow, so that the user does not take them for hung."""

import logging
import threading
from contextlib import contextmanager
from typing import Iterator

logger = logging.getLogger(__name__)

DELAY = 2.0  # s until the message is logged


@contextmanager
def log_if_slow(message: str) -> Iterator[None]:
    """Logs a message if the block is still running after `DELAY`."""
    timer = threading.Timer(DELAY, logger.info, (message,))
    timer.start()
    try:
        yield
    finally:
        timer.cancel()

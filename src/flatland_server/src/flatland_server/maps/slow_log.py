"""A line for the user when something takes long."""

import logging
import threading
from contextlib import contextmanager
from typing import Iterator

logger = logging.getLogger(__name__)

PATIENCE = 2.0  # s


@contextmanager
def log_if_slow(message: str) -> Iterator[None]:
    """Logs the message if what is done within lasts longer than `PATIENCE`, while it does."""
    timer = threading.Timer(PATIENCE, logger.info, (message,))
    timer.start()
    try:
        yield
    finally:
        timer.cancel()

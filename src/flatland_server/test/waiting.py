"""Waiting for other processes and threads."""

import time
from typing import Callable, TypeVar

T = TypeVar("T")
LIMIT = 30.0  # s: a busy machine may take much longer than an idle one


def wait_until(
    holds: Callable[[], T], what: str, limit: float = LIMIT, interval: float = 0.02
) -> T:
    """Waits for a true value of `holds()` and returns it; `holds` may raise to stop waiting.

    Args:
        holds: condition, which is called again and again.
        what: names the condition if the wait fails.
        limit: the wait's limit [s].
        interval: between two calls of `holds` [s].

    Raises:
        AssertionError: it takes too long.
    """
    deadline = time.monotonic() + limit
    while True:
        value = holds()
        if value:
            return value
        assert time.monotonic() < deadline, f"waited {limit:g} s for {what}"
        time.sleep(interval)

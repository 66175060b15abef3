"""Calls of services of one client: one after the other, on threads that all clients share."""

import asyncio
import logging
import threading
from collections import deque
from concurrent.futures import Executor, Future
from contextlib import suppress
from functools import partial
from typing import Callable, Deque, Iterable, NamedTuple

from flatland_bridge.budget import ENTRY, Budget
from flatland_bridge.graph import BridgeError
from flatland_bridge.outbox import Data, Outbox

logger = logging.getLogger(__name__)

MOST_CALLS = 50
"""Calls of a client that wait or go on."""
MOST_AT_ONCE = 4
"""Threads of a client: one that works, and others that wait for something to happen."""

Answer = Callable[[], Iterable[Data]]
"""Makes a call, on a thread of the pool. Returns what the client is sent."""

_thread = threading.local()


def let_the_next_begin() -> None:
    """Lets the next call of the same client begin: that of this thread only waits, as /step may."""
    leave = getattr(_thread, "leave", None)
    if leave is not None:
        leave()


class _Call(NamedTuple):
    size: int
    answer: Answer


class ClientCalls:
    """Makes the calls of a client in their order. It is used on the event loop's thread.

    Args:
        pool: has `MOST_AT_ONCE` threads for each client.
        budget: of the client, which is closed after the client's last call.
        outbox: gets the answers.
    """

    def __init__(self, pool: Executor, budget: Budget, outbox: Outbox) -> None:
        self._pool = pool
        self._budget = budget
        self._outbox = outbox
        self._loop = asyncio.get_running_loop()
        self._waiting: Deque[_Call] = deque()
        self._going_on = 0
        self._working: object = None  # the call that the next one waits for
        self._is_closed = False

    def add(self, size: int, answer: Answer) -> None:
        """Adds a call.

        Args:
            size: bytes of the call.
            answer: makes it.

        Raises:
            BridgeError: the client makes too many calls at a time.
        """
        if len(self._waiting) + self._going_on >= MOST_CALLS:
            raise BridgeError(f"a client may make {MOST_CALLS} calls at a time")
        self._budget.hold(size + ENTRY)
        self._waiting.append(_Call(size, answer))
        self._begin_next()

    def close(self) -> None:
        """Drops the calls that wait; those that go on end without an answer."""
        self._is_closed = True
        self._waiting.clear()
        if not self._going_on:
            self._budget.close()

    def _begin_next(self) -> None:
        if self._waiting and self._working is None and self._going_on < MOST_AT_ONCE:
            self._working = call = self._waiting.popleft()
            self._going_on += 1
            future = self._pool.submit(self._make, call)
            future.add_done_callback(lambda done: self._soon(partial(self._end, call, done)))

    def _make(self, call: _Call) -> Iterable[Data]:
        """Makes a call, on a thread of the pool."""
        _thread.leave = lambda: self._soon(partial(self._leave, call))
        try:
            return call.answer()
        finally:
            _thread.leave = None

    def _leave(self, call: _Call) -> None:
        if self._working is call:
            self._working = None
            self._begin_next()

    def _end(self, call: _Call, done: "Future[Iterable[Data]]") -> None:
        self._going_on -= 1
        self._budget.hold(-call.size - ENTRY)
        if self._is_closed:
            if not self._going_on:
                self._budget.close()
            return
        error = done.exception()
        if error is None:
            for data in done.result():
                self._outbox.reply(data)
        else:
            logger.error("a call was not answered", exc_info=error)
        self._leave(call)
        self._begin_next()

    def _soon(self, action: Callable[[], None]) -> None:
        """Calls something on the event loop's thread."""
        with suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(action)

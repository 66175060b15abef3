"""Calls of services of one client: one after the other, on threads that all clients share."""

import asyncio
import logging
import threading
from collections import deque
from concurrent.futures import Executor, Future
from contextlib import suppress
from functools import partial
from typing import Callable, Deque, Iterable, NamedTuple, Optional

from flatland_bridge.budget import ENTRY, Budget
from flatland_bridge.outbox import Data, Outbox
from flatland_server.exceptions import FlatlandError, shortened

logger = logging.getLogger(__name__)

MOST_CALLS = 50
"""Calls of a client that wait or go on."""
MOST_AT_ONCE = 4
"""Threads of a client: one that works, and others that wait for something to happen."""

Answer = Callable[[], Iterable[Data]]
"""Makes a call, on a thread of the pool. Returns what the client is sent."""
Refuse = Callable[[str], Iterable[Data]]
"""Makes what the client is sent if its call fails, out of the reason."""


class _Call(NamedTuple):
    service: str
    size: int
    answer: Answer
    refuse: Refuse


class _Thread(threading.local):
    """The call that a thread of the pool makes."""

    calls: "Optional[ClientCalls]" = None
    call: Optional[_Call] = None


_thread = _Thread()


def let_the_next_begin() -> None:
    """Lets the next call of the same client begin: that of this thread only waits, as /step may."""
    if _thread.calls is not None:
        _thread.calls.let_next_begin(_thread.call)


def reason_of(error: Exception, service: str) -> str:
    """Says to a caller why a call has failed; logs what no caller is to blame for."""
    if isinstance(error, FlatlandError):
        return str(error)
    logger.error("%s has failed", service, exc_info=error)
    return f"{service} has failed: {shortened(repr(error))}"


def client_is_gone() -> bool:
    """True on a thread that makes a call of a client that has left."""
    return _thread.calls is not None and _thread.calls.is_closed


class ClientCalls:
    """Makes the calls of a client in their order. It is used on the event loop's thread.

    Args:
        pool: runs the calls; it needs `MOST_AT_ONCE` threads for each client.
        budget: of the client, which is closed after the client's last call.
        outbox: sends the answers.

    Attributes:
        is_closed: whether the client has left.
    """

    def __init__(self, pool: Executor, budget: Budget, outbox: Outbox) -> None:
        self._pool = pool
        self._budget = budget
        self._outbox = outbox
        self._loop = asyncio.get_running_loop()
        self._waiting: Deque[_Call] = deque()
        self._going_on = 0
        self._working: Optional[_Call] = None  # the call that the next one waits for
        self.is_closed = False

    def add(self, service: str, size: int, answer: Answer, refuse: Refuse) -> None:
        """Adds a call, which is refused if the client makes too many at a time.

        Args:
            service: name of the service, for messages.
            size: bytes of the call.
            answer: makes the call and sends its answer; may raise any exception.
            refuse: called on the same thread as `answer`, or on this one.
        """
        if len(self._waiting) + self._going_on >= MOST_CALLS:
            self._reply(refuse(f"a client may make {MOST_CALLS} calls at a time"))
            return
        self._budget.hold(size + ENTRY)
        self._waiting.append(_Call(service, size, answer, refuse))
        self._begin_next()

    def close(self) -> None:
        """Drops the calls that wait; those that go on end without an answer."""
        self.is_closed = True
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
        _thread.calls, _thread.call = self, call
        try:
            return call.answer()
        except Exception as error:  # the client would wait for ever
            return call.refuse(reason_of(error, call.service))
        finally:
            _thread.calls = _thread.call = None

    def let_next_begin(self, call: Optional[_Call]) -> None:
        """Lets the call after one begin; for any thread."""
        self._soon(partial(self._leave, call))

    def _leave(self, call: Optional[_Call]) -> None:
        if self._working is call:
            self._working = None
            self._begin_next()

    def _end(self, call: _Call, done: "Future[Iterable[Data]]") -> None:
        self._going_on -= 1
        self._budget.hold(-call.size - ENTRY)
        if self.is_closed:
            if not self._going_on:
                self._budget.close()
            return
        self._reply(done.result())
        self._leave(call)
        self._begin_next()

    def _reply(self, answer: Iterable[Data]) -> None:
        for data in answer:
            self._outbox.reply(data)

    def _soon(self, action: Callable[[], None]) -> None:
        """Calls something on the event loop's thread."""
        with suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(action)

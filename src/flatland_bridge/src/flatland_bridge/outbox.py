"""Messages that wait for one client: bounded, however slow it is."""

import asyncio
import math
import sys
import threading
import time
from collections import deque
from concurrent.futures import Executor
from contextlib import suppress
from typing import Awaitable, Callable, Deque, Dict, Hashable, Optional, Sequence, Tuple, Union

from flatland_bridge.budget import Budget
from flatland_bridge.sample import Sample
from flatland_server.exceptions import shortened

Data = Union[str, bytes]
Send = Callable[[Data], Awaitable[None]]
Encode = Callable[[Sample], Sequence[Data]]
Report = Callable[[str], None]

MOST_MESSAGES = 1000
"""Messages of a topic that wait for a slow client; then the oldest is dropped."""

_ENTRY = 100
"""Bytes of a reply, besides its content."""

_TURN = 0.005
"""Real time for which a client's messages are sent before it is the others' turn [s]."""

_LARGE = 100_000
"""Bytes of messages that are encoded on another thread, while other clients are answered."""


class Stream:
    """The messages of one topic for a client.

    The oldest are dropped for a newer one that does not fit into the client's budget. A latched
    message stays in any case, since it does not come again; the server has it anyhow.

    Args:
        encode: encodes a message for the client.
        wake: called when there is something to send.
        budget: budget of the client.
        report: called once, if a message cannot be encoded.
        throttle: shortest time between two messages [s].
        length: how many messages wait; 0 is no wish. With a throttle, 0 drops what comes early.
    """

    def __init__(
        self,
        encode: Encode,
        wake: Callable[[], None],
        budget: Budget,
        report: Report = lambda text: None,
        throttle: float = 0.0,
        length: int = 0,
    ) -> None:
        self._wake = wake
        self._budget = budget
        self._report = report
        self._waiting: Deque[Tuple[Sample, int]] = deque()  # with the bytes that each counts
        self._lock = threading.Lock()  # of what waits
        self._is_closed = self._has_failed = False
        self._last = -math.inf  # when one was sent, or taken to be sent
        self.change(encode, throttle, length)

    def change(self, encode: Encode, throttle: float, length: int) -> None:
        """Changes how messages are sent, also those that wait.

        Args:
            encode: as for the class, like the others.
            throttle: counts from the last message on.
            length: also of what waits, from the next message on.
        """
        self.encode = encode
        self._throttle = throttle
        self._drops_early = throttle > 0.0 and not length
        self._length = min(length or MOST_MESSAGES, MOST_MESSAGES)
        if self._waiting:
            self._wake()

    def receive(self, sample: Sample) -> None:
        """Adds a message; for any thread."""
        if self._drops_early:
            now = time.monotonic()
            if now < self._last + self._throttle:
                return
            self._last = now
        size = sample.size
        with self._lock:
            if self._is_closed:
                return
            while len(self._waiting) >= self._length:
                self._drop()
            while not self._budget.offer(size):
                if self._waiting:
                    self._drop()
                elif sample.is_latched:
                    size = 0
                else:
                    return
            self._waiting.append((sample, size))
        self._wake()

    def take(self, now: float) -> Optional[Sample]:
        """The next message, if there is one that may be sent now."""
        if self.delay(now) > 0.0:
            return None
        with self._lock:
            if not self._waiting:  # a newer one that did not fit has made room
                return None
            sample = self._drop()
        if not self._drops_early:
            self._last = now
        return sample

    def delay(self, now: float) -> float:
        """Time until the next message may be sent [s]; infinite if there is none."""
        if not self._waiting:
            return math.inf
        return 0.0 if self._drops_early else max(0.0, self._last + self._throttle - now)

    def leave_out(self, sample: Sample, error: Exception) -> None:
        """Reports a message that cannot be encoded: once, or there would be a report of each.

        Args:
            sample: message that is not sent.
            error: exception of the encoding.
        """
        if not self._has_failed:
            self._has_failed = True
            text = shortened(f"{type(error).__name__}: {error}")
            self._report(f"{sample.topic}: messages that cannot be encoded are left out: {text}")

    def close(self) -> None:
        """Drops all messages, also those that come later."""
        with self._lock:
            self._is_closed = True
            while self._waiting:
                self._drop()

    def _drop(self) -> Sample:
        sample, size = self._waiting.popleft()
        self._budget.release(size)
        return sample


class Outbox:
    """All that waits for one client. Its methods but `wake` are for the event loop's thread.

    Args:
        budget: budget of the client.
        pool: encodes large messages on other threads.
    """

    def __init__(self, budget: Budget, pool: Executor) -> None:
        self._streams: Dict[Hashable, Stream] = {}
        self._budget = budget
        self._pool = pool
        self._loop = asyncio.get_running_loop()
        self._replies: Deque[Tuple[Data, Callable[[int], None]]] = deque()  # and what counts them
        self._event = asyncio.Event()
        self._is_awake = False

    def wake(self) -> None:
        """Makes `send_all` look for messages; for any thread."""
        if not self._is_awake:
            self._is_awake = True
            with suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(self._event.set)

    def open(self, key: Hashable, stream: Stream) -> None:
        """Adds a stream, in place of one with the same key.

        Args:
            key: the topic, or as the protocol tells subscriptions apart.
            stream: source of the messages.
        """
        self.close(key)
        self._streams[key] = stream

    def close(self, key: Hashable) -> None:
        """Drops a stream, if there is one."""
        stream = self._streams.pop(key, None)
        if stream is not None:
            stream.close()

    def close_all(self) -> None:
        """Drops all that waits."""
        for key in list(self._streams):
            self.close(key)
        while self._replies:
            data, count = self._replies.popleft()
            count(-_size(data))

    def reply(self, data: Data, payer: Optional[Budget] = None) -> None:
        """Adds a reply, which is never dropped. If no other waits, it may have any size.

        Args:
            data: encoded reply.
            payer: the budget of another client that has caused it, and in which it counts.
        """
        if payer is not None:
            count = payer.hold
        else:
            count = self._budget.hold if self._replies else self._budget.send
        count(_size(data))
        self._replies.append((data, count))
        self.wake()

    async def send_all(self, send: Send) -> None:
        """Sends messages for ever.

        Args:
            send: sends one; waits while the client does not read.
        """
        while True:
            await self._wait()
            self._event.clear()
            self._is_awake = False
            is_sending, turn_ends = True, time.monotonic() + _TURN
            while is_sending:  # one message of each topic in turn
                is_sending = False
                for stream in list(self._streams.values()):
                    if self._replies:
                        await self._send_replies(send)
                    sample = stream.take(time.monotonic())
                    if sample is not None:
                        is_sending = True
                        await self._send_sample(send, stream, sample)
                if time.monotonic() > turn_ends:  # the other clients' turn
                    await asyncio.sleep(0)
                    turn_ends = time.monotonic() + _TURN
            await self._send_replies(send)

    async def _send_replies(self, send: Send) -> None:
        while self._replies:
            data, count = self._replies.popleft()
            try:
                await send(data)
            finally:
                count(-_size(data))

    async def _send_sample(self, send: Send, stream: Stream, sample: Sample) -> None:
        try:
            if sample.size > _LARGE:
                pieces = await self._loop.run_in_executor(self._pool, stream.encode, sample)
            else:
                pieces = stream.encode(sample)
        except Exception as error:  # of any kind: a plugin may have set values of any type
            stream.leave_out(sample, error)
            return
        size = sum(map(_size, pieces))
        self._budget.send(size)
        try:
            for data in pieces:
                await send(data)
        finally:
            self._budget.send(-size)

    async def _wait(self) -> None:
        now = time.monotonic()
        delay = min((each.delay(now) for each in self._streams.values()), default=math.inf)
        if delay == math.inf:
            await self._event.wait()
            return
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._event.wait(), delay)


def _size(data: Data) -> int:
    """Bytes in memory, with the entry in a queue."""
    return sys.getsizeof(data) + _ENTRY

"""Messages that wait for one client: bounded, however slow it is."""

import asyncio
import time
from collections import deque
from contextlib import suppress
from typing import Awaitable, Callable, Deque, Dict, Hashable, Iterable, Optional, Union

from flatland_bridge.graph import Sample

Data = Union[str, bytes]
Send = Callable[[Data], Awaitable[None]]
Encode = Callable[[Sample], Iterable[Data]]

MOST_MESSAGES = 100
"""Messages of a topic that wait for a slow client; then the oldest is dropped."""

_MOST_REPLIES = 1000
"""Replies that wait for a client; if there are more, it is disconnected."""


class Stream:
    """The messages of one topic for a client.

    Args:
        encode: makes what is sent of a message.
        wake: called when there is something to send.
        throttle: shortest time between two messages [s].
        length: how many messages wait; None is no wish. With a throttle, 0 drops what comes early.
    """

    def __init__(
        self,
        encode: Encode,
        wake: Callable[[], None],
        throttle: float = 0.0,
        length: Optional[int] = None,
    ) -> None:
        self.encode = encode
        self._wake = wake
        self._throttle = throttle
        self._drops_early = throttle > 0.0 and not length
        self._waiting: Deque[Sample] = deque(maxlen=min(length or MOST_MESSAGES, MOST_MESSAGES))
        self._due = 0.0  # when the next one may be sent

    def receive(self, sample: Sample) -> None:
        """Adds a message; for any thread."""
        if self._drops_early:
            now = time.monotonic()
            if now < self._due:
                return
            self._due = now + self._throttle
        self._waiting.append(sample)
        self._wake()

    def take(self, now: float) -> Optional[Sample]:
        """The next message, if there is one that may be sent now."""
        if not self._waiting or self.delay(now) > 0.0:
            return None
        if not self._drops_early:
            self._due = now + self._throttle
        return self._waiting.popleft()

    def delay(self, now: float) -> float:
        """Time until the next message may be sent [s]; infinite if there is none."""
        if not self._waiting:
            return float("inf")
        return 0.0 if self._drops_early else max(0.0, self._due - now)


class Outbox:
    """All that waits for one client. Its methods but `wake` are for the event loop's thread."""

    def __init__(self) -> None:
        self.streams: Dict[Hashable, Stream] = {}
        """By topic, or as the protocol tells subscriptions apart."""
        self._loop = asyncio.get_running_loop()
        self._replies: Deque[Data] = deque()
        self._event = asyncio.Event()
        self._is_awake = False

    def wake(self) -> None:
        """Makes `send_all` look for messages; for any thread."""
        if not self._is_awake:
            self._is_awake = True
            with suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(self._event.set)

    def reply(self, data: Data) -> None:
        """Adds a reply, which is never dropped.

        Raises:
            ConnectionError: too many replies wait.
        """
        if len(self._replies) >= _MOST_REPLIES:
            raise ConnectionError("the client does not read its replies")
        self._replies.append(data)
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
            is_sending = True
            while is_sending:  # one message of each topic in turn
                is_sending = False
                for stream in list(self.streams.values()):
                    while self._replies:
                        await send(self._replies.popleft())
                    sample = stream.take(time.monotonic())
                    if sample is not None:
                        is_sending = True
                        for data in stream.encode(sample):
                            await send(data)
            while self._replies:
                await send(self._replies.popleft())

    async def _wait(self) -> None:
        now = time.monotonic()
        delay = min((each.delay(now) for each in self.streams.values()), default=float("inf"))
        if delay == float("inf"):
            await self._event.wait()
            return
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._event.wait(), delay)

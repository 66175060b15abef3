"""A `LocalTransport` whose simulation other threads talk to."""

import logging
import threading
import time
from collections import deque
from typing import Any, Callable, Deque, Dict, Mapping, Set

from flatland_bridge.graph import BridgeError
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.thread_calls import ThreadCalls
from flatland_server.transport.topic_registry import ANY_TYPE, type_name
from flatland_server.transport.transport import Publisher, Subscription

logger = logging.getLogger(__name__)

_MOST_WAITING = 1000
"""Messages and calls that wait for the next step; further ones are refused."""


class SharedTransport(ThreadCalls, LocalTransport):
    """Runs what other threads ask for on the simulation's thread, between steps.

    Args:
        params: parameters by absolute name.

    Attributes:
        types: the types of all topics that were opened, by absolute name.
        latched: the absolute names of those that send their last message to new subscribers.
        is_ending: makes `process` return at once.
    """

    def __init__(self, params: Mapping[str, Any]) -> None:
        super().__init__(dict(params), ())
        self.types: Dict[str, str] = {}
        self.latched: Set[str] = set()
        self.is_ending = False
        self._waiting: Deque[Callable[[], None]] = deque()
        self._arrival = threading.Event()

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        name = self.resolve(topic)
        self.types[name] = type_name(message_type)
        (self.latched.add if latch else self.latched.discard)(name)
        return super().advertise(topic, message_type, latch=latch, queue_size=queue_size)

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        if type_name(message_type) != ANY_TYPE:
            self.types[self.resolve(topic)] = type_name(message_type)
        return super().subscribe(topic, message_type, callback)

    def post(self, action: Callable[[], None]) -> None:
        """Queues an action for the simulation's thread.

        Args:
            action: called between two steps.

        Raises:
            BridgeError: too many wait already.
        """
        if len(self._waiting) >= _MOST_WAITING:
            raise BridgeError("the simulation cannot keep up with messages and calls")
        self._waiting.append(action)
        self._arrival.set()

    def end_error(self) -> Exception:
        return BridgeError("the simulation has ended")

    def process(self, timeout: float = 0.0) -> None:
        self._run_waiting()
        if timeout <= 0.0:
            return
        deadline = time.monotonic() + timeout
        remaining = timeout
        while remaining > 0.0 and not self.is_ending:
            if self._arrival.wait(remaining):
                self._run_waiting()
                if self.returns_on_arrival:
                    return
            remaining = deadline - time.monotonic()

    def _run_waiting(self) -> None:
        self._arrival.clear()
        while self._waiting:
            try:
                self._waiting.popleft()()
            except Exception:
                logger.exception("a client's request failed")
        super().process()

"""A `LocalTransport` whose simulation other threads talk to."""

import logging
import threading
import time
from collections import deque
from concurrent.futures import Future, wait
from typing import Any, Callable, Deque, Dict, Mapping, TypeVar

from flatland_bridge.graph import BridgeError
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.topic_registry import ANY_TYPE, type_name
from flatland_server.transport.transport import Publisher, Subscription

logger = logging.getLogger(__name__)

T = TypeVar("T")

_MOST_WAITING = 1000
"""Messages and calls that wait for the next step; further ones are refused."""

_END_CHECK_PERIOD = 0.1  # s


class SharedTransport(LocalTransport):
    """Runs what other threads ask for on the simulation's thread, between steps.

    Args:
        params: parameters by absolute name.

    Attributes:
        types: the types of all topics that were opened, by absolute name.
        is_ending: makes `process` return at once.
    """

    def __init__(self, params: Mapping[str, Any]) -> None:
        super().__init__(dict(params), ())
        self.types: Dict[str, str] = {}
        self.is_ending = False
        self._waiting: Deque[Callable[[], None]] = deque()
        self._arrival = threading.Event()

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        self.types[self.resolve(topic)] = type_name(message_type)
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

    def call(self, function: Callable[[], T]) -> T:
        """Runs a function on the simulation's thread, between steps, and returns its result.

        Args:
            function: raises what this raises.

        Raises:
            BridgeError: too many calls wait, or the simulation ends.
        """
        future: Future[T] = Future()

        def run() -> None:
            try:
                future.set_result(function())
            except BaseException as error:
                future.set_exception(error)

        self.post(run)
        return self.wait(future)

    def wait(self, future: "Future[T]") -> T:
        """Waits for a result of the simulation's thread.

        Args:
            future: raises what this raises.

        Raises:
            BridgeError: the simulation ends.
        """
        while not wait([future], _END_CHECK_PERIOD).done:
            if self.is_ending:
                raise BridgeError("the simulation has ended")
        return future.result()

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

"""A `LocalTransport` for a simulation that other threads talk to."""

import threading
from collections import Counter, deque
from concurrent.futures import Future
from functools import partial
from typing import Any, Callable, Deque, Dict, Hashable, Mapping, Set, Tuple, TypeVar
from typing import Counter as CounterType

from flatland_bridge.client_calls import let_the_next_begin
from flatland_bridge.graph import NODE, BridgeError
from flatland_bridge.parameters import LocalParameters
from flatland_server.hub import Failures
from flatland_server.transport import (
    ANY_TYPE,
    LocalTransport,
    Publisher,
    ServedTransport,
    Subscription,
    type_name,
)

T = TypeVar("T")

_MOST_WAITING = 1000
"""Messages and calls of a client that wait for the next step; further ones are refused."""


class SharedTransport(LocalTransport, ServedTransport):
    """Runs what other threads ask for on the simulation's thread, between steps.

    Args:
        params: parameters by absolute name.

    Attributes:
        types: the types of all topics that were opened, by absolute name.
        latched: the absolute names of those that send their last message to new subscribers.
        failures: of what is called for clients.
        parameters: those given, and those that clients set.
        is_ending: makes `process` return at once.
    """

    def __init__(self, params: Mapping[str, Any]) -> None:
        super().__init__({}, ())
        self.parameters = LocalParameters(params, NODE)
        self.types: Dict[str, str] = {}
        self.latched: Set[str] = set()
        self.is_ending = False
        self.failures = Failures()
        self._waiting: Deque[Tuple[Callable[[], None], Hashable]] = deque()
        self._numbers: CounterType[Hashable] = Counter()  # of those, by client
        self._lock = threading.Lock()

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
        return super().subscribe(topic, message_type, partial(self.failures.catch, callback))

    def get_param(self, name: str, default: Any = None) -> Any:
        return self.parameters.get(name.replace("~", f"{NODE}/"), default)

    def post(self, action: Callable[[], None], client: Hashable = None) -> None:
        """Queues an action for the simulation's thread.

        Args:
            action: called once, between two steps.
            client: asks for it; None is any that has few of them.

        Raises:
            BridgeError: too many of the client wait already.
        """
        with self._lock:
            if self._numbers[client] >= _MOST_WAITING:
                raise BridgeError("the simulation cannot keep up with messages and calls")
            self._numbers[client] += 1
            self._waiting.append((action, client))
        self._arrival.set()

    def end_error(self) -> Exception:
        return BridgeError("the simulation has ended")

    def wait(self, future: "Future[T]") -> T:
        let_the_next_begin()  # one that ends the wait, such as /pause
        return super().wait(future)

    def process(self, timeout: float = 0.0) -> None:
        self._arrival.clear()
        self._run_posted()
        if timeout > 0.0:
            self._run_for(timeout)

    def _run_posted(self) -> None:
        for _ in range(len(self._waiting)):  # not those that come meanwhile: time goes on
            with self._lock:
                action, client = self._waiting.popleft()
                self._numbers[client] -= 1
                if not self._numbers[client]:
                    del self._numbers[client]
            self.failures.catch(action)
        super().process()

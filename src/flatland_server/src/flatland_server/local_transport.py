"""Topics within this process: for unit tests, batch runs and Python programs without a master.

transport = LocalTransport()
manager = SimulationManager(World.from_file(path, transport), Timekeeper(0.005))
transport.send("/cmd_vel", twist)         # hand a command in
manager.step()
transport.last("/odometry/ground_truth")  # the newest message of a topic, or None
"""

from collections import Counter, deque
from typing import Any, Callable, Container, Deque, Dict, List, Optional, Set, Tuple
from typing import Counter as CounterType

from flatland_server.geometry import Transform
from flatland_server.message_writer import MessageWriter
from flatland_server.node import Publisher, Subscription, Transport


class LocalTransport(Transport):
    """Keeps the last message of each topic, and the last transform of each frame.

    Args:
        params: parameters by absolute name.
        watched: the topics that somebody listens to; all of them if None. What nobody listens to is
            not computed, as with ROS, unless it is asked to be.
    """

    def __init__(
        self,
        params: Dict[str, Any] = {},  # noqa: B006 (only read)
        watched: Optional[Container[str]] = None,
    ) -> None:
        self.transforms: Dict[str, Transform] = {}
        self._params = dict(params)
        self._watched = watched
        self._version = 0
        self._publishers: CounterType[str] = Counter()
        self._last: Dict[str, Any] = {}
        self._inbox: Deque[Tuple[str, Any]] = deque()
        self._callbacks: Dict[str, List[Callable[[Any], None]]] = {}

    def send(self, topic: str, message: Any) -> None:
        """Hands a message to whoever subscribes to a topic, before the next step."""
        self._inbox.append((_absolute(topic), message))

    def last(self, topic: str) -> Any:
        """The newest message published to a topic, or None."""
        return self._last.get(_absolute(topic))

    @property
    def topics(self) -> Set[str]:
        """The topics that somebody publishes to."""
        return set(self._publishers)

    @property
    def subscribed(self) -> Set[str]:
        """The topics that somebody listens to in here."""
        return {topic for topic, callbacks in self._callbacks.items() if callbacks}

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        return _LocalPublisher(self, _absolute(topic))

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        callbacks = self._callbacks.setdefault(_absolute(topic), [])
        return _LocalSubscription(callbacks, callback)

    def watch(self, topics: Optional[Container[str]]) -> None:
        """Says which topics somebody listens to from now on; all of them if None."""
        self._watched = topics
        self._version += 1

    def is_watched(self, topic: str) -> bool:
        """Whether somebody listens to a topic."""
        return self._watched is None or _absolute(topic) in self._watched

    @property
    def transforms_are_watched(self) -> bool:
        return self.is_watched("/tf")

    @property
    def listeners_version(self) -> object:
        return self._version

    def send_transform(self, transform: Transform) -> None:
        self.transforms[transform.child] = transform

    def get_param(self, name: str, default: Any = None) -> Any:
        return self._params.get(_absolute(name), default)

    def process(self, timeout: float = 0.0) -> None:
        while self._inbox:
            topic, message = self._inbox.popleft()
            for callback in list(self._callbacks.get(topic, [])):
                callback(message)

    def flush(self) -> None:
        pass


class _LocalPublisher(Publisher):
    def __init__(self, transport: LocalTransport, topic: str) -> None:
        self._transport = transport
        self._topic = topic
        self._is_closed = False
        transport._publishers[topic] += 1

    @property
    def is_watched(self) -> bool:
        return self._transport.is_watched(self._topic)

    def publish(self, message: Any) -> None:
        self._transport._last[self._topic] = message

    def write(self, writer: MessageWriter, *values: Any) -> None:
        if self.is_watched:
            self.publish(writer.message(*values))

    def close(self) -> None:
        if self._is_closed:
            return
        self._is_closed = True
        publishers = self._transport._publishers
        publishers[self._topic] -= 1
        if publishers[self._topic] == 0:
            del publishers[self._topic]
            self._transport._last.pop(self._topic, None)


class _LocalSubscription(Subscription):
    def __init__(
        self, callbacks: List[Callable[[Any], None]], callback: Callable[[Any], None]
    ) -> None:
        self._callbacks = callbacks
        self._callback = callback
        callbacks.append(callback)

    def close(self) -> None:
        if self._callback in self._callbacks:
            self._callbacks.remove(self._callback)


def _absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"

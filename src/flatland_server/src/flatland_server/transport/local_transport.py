"""Topics within this process: for unit tests, batch runs and Python programs without a master.

Plugins that subscribe to a topic get the messages that others publish at the end of the step.

transport = LocalTransport()
run = Run(World.from_file(path, transport), Timekeeper(0.005))
transport.send("/cmd_vel", twist)         # to the subscribers of a topic, before the next step
run.step()
transport.last("/odometry/ground_truth")  # the last message published to a topic, or None
"""

from abc import ABC, abstractmethod
from collections import Counter, deque
from contextlib import contextmanager
from typing import Any, Callable, Container, Deque, Dict, Iterator, List, Optional, Set, Tuple
from typing import Counter as CounterType

from flatland_server.geometry import Transform
from flatland_server.transport.transforms import TF_STATIC, StaticTransforms
from flatland_server.transport.transport import Publisher, Subscription, Transport


class Tap(ABC):
    """Receives messages and transforms at once when they are published or sent.

    It counts as a subscriber to the topics that it records.
    """

    @abstractmethod
    def wants(self, topic: str) -> bool:
        """True if the messages of a topic are to be received.

        Args:
            topic: absolute name of the topic; also "/tf".
        """

    @abstractmethod
    def receive(self, topic: str, message: Any, is_latched: bool) -> None:
        """Receives a message of a topic that it wants.

        Args:
            topic: absolute name of the topic, such as "/robot1/scan".
            message: a message of the topic.
            is_latched: whether new subscribers get it, too.
        """

    @abstractmethod
    def receive_transform(self, transform: Transform) -> None:
        """Receives a transform, if it wants "/tf".

        Args:
            transform: transform at one time.
        """


class LocalTransport(Transport):
    """Keeps the last message of each topic, and in `transforms` the last one of each frame.

    Args:
        params: parameters by absolute name.
        subscribed_topics: the topics that count as having a subscriber; None is all of them. As
            with ROS, plugins compute nothing for the others.

    Attributes:
        transforms: by the name of the child frame.
        static_transforms: those of /tf_static, without a namespace.
        params_read: the parameters that were asked for, by absolute name.
    """

    def __init__(
        self,
        params: Dict[str, Any] = {},  # noqa: B006 (only read)
        subscribed_topics: Optional[Container[str]] = None,
    ) -> None:
        super().__init__()
        self.transforms: Dict[str, Transform] = {}
        self.params_read: Set[str] = set()
        self._params = {absolute_name(name): value for name, value in params.items()}
        self._subscribed_topics = subscribed_topics
        self.activity = 0
        self._subscriber_revision = 0
        self._publishers: CounterType[str] = Counter()
        self._last: Dict[str, Tuple[_LocalPublisher, Any]] = {}
        self._inbox: Deque[Tuple[str, Any]] = deque()
        self._callbacks: Dict[str, List[Callable[[Any], None]]] = {}
        self._published: List[Tuple[str, Callable[[Any], None], Any]] = []  # to be delivered
        self._is_delivering = True
        self._taps: Tuple[Tap, ...] = ()
        self.static_transforms = self._open_static(TF_STATIC)
        self._statics = {TF_STATIC: self.static_transforms}

    def send(self, topic: str, message: Any) -> None:
        """Sends a message to the subscribers of a topic; `process` runs their callbacks.

        Args:
            topic: name of the topic, with or without a leading "/".
            message: the message, of the topic's type; see `messages.get`.
        """
        name = absolute_name(topic)
        self._inbox.append((name, message))
        self.activity += 1
        if self._taps:
            self._pass_on(name, message, is_latched=False)

    def last(self, topic: str) -> Any:
        """The last message published to a topic, or None.

        Args:
            topic: name of the topic, with or without a leading "/".
        """
        return self._last.get(absolute_name(topic), (None, None))[1]

    def last_latched(self, topic: str) -> Any:
        """The last message of a topic if it is latched, or None.

        Args:
            topic: name of the topic, with or without a leading "/".
        """
        publisher, message = self._last.get(absolute_name(topic), (None, None))
        return message if publisher is not None and publisher.is_latched else None

    @property
    def topics(self) -> Set[str]:
        """The topics that have a publisher."""
        return set(self._publishers)

    @property
    def subscribed(self) -> Set[str]:
        """The topics that have a callback here."""
        return {topic for topic, callbacks in self._callbacks.items() if callbacks}

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        name = absolute_name(topic)
        if name.endswith(TF_STATIC):
            if name not in self._statics:
                self._statics[name] = self._open_static(name)
            return self._statics[name].advertise()
        return _LocalPublisher(self, name, latch)

    def _open_static(self, topic: str) -> StaticTransforms:
        static = StaticTransforms(
            lambda: _LocalPublisher(self, topic, True), lambda: static.publish()
        )
        return static

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        topic = absolute_name(topic)
        callbacks = self._callbacks.setdefault(topic, [])
        self._subscribers_change()
        publisher, message = self._last.get(topic, (None, None))
        if publisher is not None and publisher.is_latched:
            self._published.append((topic, callback, message))
        return _LocalSubscription(self, topic, message_type, callbacks, callback)

    def set_subscribed_topics(self, topics: Optional[Container[str]]) -> None:
        """Changes which topics count as having a subscriber.

        Args:
            topics: their absolute names; None is all topics.
        """
        self._subscribed_topics = topics
        self._subscribers_change()

    def has_subscribers(self, topic: str) -> bool:
        """True if a topic counts as having a subscriber.

        Args:
            topic: name of the topic, with or without a leading "/".
        """
        topics, name = self._subscribed_topics, absolute_name(topic)
        if topics is None or name in topics or self._callbacks.get(name):
            return True
        return bool(self._taps) and any(tap.wants(name) for tap in self._taps)

    def open_tap(self, tap: Tap) -> None:
        """Passes on all messages from now on, and first the last ones of latched topics.

        Args:
            tap: tap that receives the messages.
        """
        self._taps = (*self._taps, tap)
        self._subscribers_change()
        for topic, (publisher, message) in self._last.items():
            if publisher.is_latched and tap.wants(topic):
                tap.receive(topic, message, True)

    def close_tap(self, tap: Tap) -> None:
        """Stops passing messages to a tap.

        Args:
            tap: tap that receives no further messages.
        """
        self._taps = tuple(each for each in self._taps if each is not tap)
        self._subscribers_change()

    @property
    def transforms_have_subscribers(self) -> bool:
        return self.has_subscribers("/tf")

    @property
    def subscriber_revision(self) -> object:
        return self._subscriber_revision

    @property
    def has_to_deliver(self) -> bool:
        return bool(self._published)

    def send_transform(self, transform: Transform) -> None:
        self.transforms[transform.child] = transform
        for tap in self._taps:
            if tap.wants("/tf"):
                tap.receive_transform(transform)

    def get_param(self, name: str, default: Any = None) -> Any:
        name = absolute_name(name)
        self.params_read.add(name)
        return self._params.get(name, default)

    def process(self, timeout: float = 0.0) -> None:
        while self._inbox:
            topic, message = self._inbox.popleft()
            self.arrivals.note(topic)
            callbacks = list(self._callbacks.get(topic, []))
            if callbacks and self.on_input is not None:
                self.on_input(topic, message)
            for callback in callbacks:
                callback(message)

    def flush(self) -> None:
        if self.on_flush:
            for send in self.on_flush:
                send()
        if self._published:
            self._deliver()
        self.arrivals.next_step()

    def _deliver(self) -> None:
        """Runs the callbacks for published messages; what they publish waits for the next step."""
        published, self._published = self._published, []
        for topic, callback, message in published:
            if callback in self._callbacks.get(topic, ()):
                self.arrivals.note(topic)
                callback(message)

    @contextmanager
    def without_delivery(self) -> Iterator[None]:
        """A context in which published messages can be read by `last` but reach no callback."""
        self._is_delivering = False
        try:
            yield
        finally:
            self._is_delivering = True

    def discard(self) -> None:
        self.transforms.clear()
        self._inbox.clear()
        self._published.clear()

    def _subscribers_change(self) -> None:
        self._subscriber_revision += 1
        self.activity += 1

    def _pass_on(self, topic: str, message: Any, is_latched: bool) -> None:
        for tap in self._taps:
            if tap.wants(topic):
                tap.receive(topic, message, is_latched)


class _LocalPublisher(Publisher):
    def __init__(self, transport: LocalTransport, topic: str, is_latched: bool) -> None:
        self._transport = transport
        self._topic = topic
        self.is_latched = is_latched
        self._is_closed = False
        transport._publishers[topic] += 1

    @property
    def has_subscribers(self) -> bool:
        return self._transport.has_subscribers(self._topic)

    def publish(self, message: Any) -> None:
        transport = self._transport
        transport._last[self._topic] = (self, message)
        if transport._is_delivering:
            for callback in transport._callbacks.get(self._topic, ()):
                transport._published.append((self._topic, callback, message))
                transport.activity += 1
        if transport._taps:
            transport._pass_on(self._topic, message, self.is_latched)

    def close(self) -> None:
        if self._is_closed:
            return
        self._is_closed = True
        publishers = self._transport._publishers
        publishers[self._topic] -= 1
        if publishers[self._topic] == 0:
            del publishers[self._topic]
        last = self._transport._last
        if self._topic in last and last[self._topic][0] is self:
            del last[self._topic]


class _LocalSubscription(Subscription):
    def __init__(
        self,
        transport: LocalTransport,
        topic: str,
        message_type: Any,
        callbacks: List[Callable[[Any], None]],
        callback: Callable[[Any], None],
    ) -> None:
        self._transport = transport
        self._arrival = transport.arrivals.open(topic, message_type)
        self._callbacks = callbacks
        self._callback = callback
        callbacks.append(callback)

    def close(self) -> None:
        self._transport.arrivals.close(self._arrival)
        if self._callback in self._callbacks:
            self._callbacks.remove(self._callback)
            self._transport._subscribers_change()


def absolute_name(name: str) -> str:
    """The absolute name of a topic or parameter, for the empty namespace."""
    return name if name.startswith("/") else f"/{name}"

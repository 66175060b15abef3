"""The interface between protocols and what they show: topics and services, from any thread."""

from abc import ABC, abstractmethod
from collections import deque
from typing import Any, Callable, Deque, Dict, FrozenSet, List, NamedTuple, Optional, Tuple

from flatland_bridge.budget import Budget
from flatland_bridge.message_size import size_of
from flatland_bridge.parameters import Parameters
from flatland_server.exceptions import FlatlandError, suggestion
from flatland_server.messages.message_types import deserialized
from flatland_server.messages.service_types import ServiceType
from flatland_server.messages.wire_form import serialized


class BridgeError(FlatlandError):
    """A client asks for a topic or service that does not exist, or for too much."""


def require_type(topic: str, expected: Optional[str], message: Any) -> None:
    """Raises a BridgeError if a topic has another type than a message.

    Args:
        topic: its absolute name.
        expected: the topic's type; None if it is not known.
        message: to be published.
    """
    if expected not in (None, message._type):
        raise BridgeError(f'the topic "{topic}" expects {expected}, found {message._type}')


_ENTRY = 1000
"""Bytes of a message without its content."""

_MOST_KEPT, _LARGEST_KEPT = 64, 64_000
_kept: Deque[Tuple[Dict[str, bytes], str]] = deque()
"""The latest encodings of messages, for further clients that want the same: 64 of at most 64 kB."""


class Sample:
    """A message of a topic, converted once for all clients.

    Args:
        topic: its absolute name.
        nanoseconds: simulated time [ns].
        message_type: the class of the message.
        message: the message, which may be serialized in advance; or None.
        data: the serialized message, if there is no message.
        is_latched: whether it is kept anyway, for new subscribers.
    """

    def __init__(
        self,
        topic: str,
        nanoseconds: int,
        message_type: Any,
        message: Optional[Any] = None,
        data: Optional[bytes] = None,
        is_latched: bool = False,
    ) -> None:
        self.topic = topic
        self.nanoseconds = nanoseconds
        self.message_type = message_type
        self.is_latched = is_latched
        self._message = message
        self._data = data
        self._size: Optional[int] = None
        self._encodings: Dict[str, bytes] = {}

    @property
    def message(self) -> Any:
        """The message with all of its fields."""
        # One that is serialized in advance, or when it is sent, has no fields.
        if type(self._message) is self.message_type:
            return self._message
        return deserialized(self.message_type, self.data)

    @property
    def data(self) -> bytes:
        """The serialized message."""
        if self._data is not None:
            return self._data
        return self.encoded("ros1", lambda sample: serialized(sample._message))

    def encoded(self, name: str, encode: Callable[["Sample"], bytes]) -> bytes:
        """The bytes that a protocol sends.

        Args:
            name: of the encoding.
            encode: makes them.
        """
        data = self._encodings.get(name)
        if data is None:
            data = encode(self)
            if len(data) <= _LARGEST_KEPT:
                self._encodings[name] = data
                _kept.append((self._encodings, name))
                if len(_kept) > _MOST_KEPT:
                    encodings, oldest = _kept.popleft()
                    encodings.pop(oldest, None)
        return data

    @property
    def size(self) -> int:
        """The memory that it takes while it waits, roughly [bytes]."""
        if self._size is None:
            if self._data is not None:
                size = len(self._data)
            elif type(self._message) is self.message_type:
                size = size_of(self._message)
            else:
                size = len(getattr(self._message, "_data", b""))
            self._size = _ENTRY + size
        return self._size


Receive = Callable[[Sample], None]
"""Receives a message. It is called on a thread of the graph, and must return at once."""


class Topics(NamedTuple):
    """The types of topics by their absolute names.

    Attributes:
        published: topics with a publisher.
        subscribed: topics with a subscriber.
        latched: names of the topics that send their last message to new subscribers.
    """

    published: Dict[str, str]
    subscribed: Dict[str, str]
    latched: FrozenSet[str] = frozenset()

    @property
    def types(self) -> Dict[str, str]:
        """All topics."""
        return {**self.subscribed, **self.published}


NODE = "/flatland_server"
"""The node that a simulation without ROS is."""


class Nodes(NamedTuple):
    """The names of nodes.

    Attributes:
        publishers: of each topic.
        subscribers: of each topic.
        services: of each service, the node that offers it.
    """

    publishers: Dict[str, List[str]]
    subscribers: Dict[str, List[str]]
    services: Dict[str, List[str]]


class Graph(ABC):
    """Topics, services and parameters. All methods may be called on any thread.

    Attributes:
        parameters: those that clients see and set.
    """

    parameters: Parameters

    @property
    @abstractmethod
    def topics(self) -> Topics:
        """The present topics."""

    @property
    @abstractmethod
    def services(self) -> Dict[str, ServiceType]:
        """The present services by their absolute names."""

    @property
    def nodes(self) -> Nodes:
        """The present nodes."""
        named = (self.topics.published, self.topics.subscribed, self.services)
        return Nodes(*({name: [NODE] for name in names} for names in named))

    @property
    @abstractmethod
    def nanoseconds(self) -> int:
        """Simulated time [ns]."""

    @abstractmethod
    def subscribe(
        self, topic: str, receive: Receive, client: Optional[Budget] = None
    ) -> Callable[[], None]:
        """Subscribes to a topic, which need not exist yet.

        Once more with an equal function, it only gets the last message of a latched topic again.

        Args:
            topic: its absolute name.
            receive: called with each message; first with the last one if the topic is latched.
            client: has asked for it, and counts what waits until it is done.

        Returns:
            A function that ends the subscription.
        """

    def advertise(self, topic: str, message_type: Any) -> Callable[[], None]:
        """Prepares to publish to a topic.

        Args:
            topic: its absolute name.
            message_type: the class of its messages.

        Returns:
            A function that ends it.
        """
        return lambda: None

    @abstractmethod
    def publish(self, topic: str, message: Any, client: Optional[Budget] = None) -> None:
        """Publishes a message.

        Args:
            topic: its absolute name; advertised, unless the graph is a simulation.
            message: of the topic's type.
            client: as for `subscribe`.

        Raises:
            BridgeError: the topic has another type, or too many messages wait.
        """

    @abstractmethod
    def call(self, service: str, request: Any) -> Any:
        """Calls a service, waits for its response and returns it.

        Args:
            service: its absolute name.
            request: of the service's type.

        Raises:
            FlatlandError: there is no such service, or the call has failed.
        """

    def service_type(self, service: str) -> ServiceType:
        """The type of a service.

        Args:
            service: its absolute name.

        Raises:
            BridgeError: there is no such service.
        """
        services = self.services
        if service not in services:
            hint = suggestion(service, services)
            raise BridgeError(f'there is no service "{service}"{hint}')
        return services[service]

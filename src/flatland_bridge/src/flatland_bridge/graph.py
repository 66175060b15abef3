"""The interface between protocols and what they show: topics and services, from any thread."""

from abc import ABC, abstractmethod
from typing import Any, Callable, Dict, FrozenSet, List, NamedTuple, Optional

from flatland_bridge.budget import Budget
from flatland_bridge.parameters import Parameters
from flatland_bridge.sample import Sample
from flatland_server.exceptions import FlatlandError, suggestion
from flatland_server.messages import ServiceType


class BridgeError(FlatlandError):
    """A client asks for a topic or service that does not exist, or for too much."""


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
            topic: absolute name of the topic, such as "/robot1/scan".
            receive: called with each message; first with the last one if the topic is latched.
            client: client that asked for it; its budget counts the messages that wait.

        Returns:
            A function that ends the subscription.
        """

    def advertise(self, topic: str, message_type: Any) -> Callable[[], None]:
        """Prepares to publish to a topic.

        Returns:
            A function that ends it.
        """
        return lambda: None

    @abstractmethod
    def publish(self, topic: str, message: Any, client: Optional[Budget] = None) -> None:
        """Publishes a message.

        Args:
            topic: its absolute name; advertised, unless the graph is a simulation.
            message: the message, of the topic's type.
            client: as for `subscribe`.

        Raises:
            BridgeError: the topic has another type, or too many messages wait.
        """

    @abstractmethod
    def call(self, service: str, request: Any) -> Any:
        """Calls a service, waits for its response and returns it.

        Raises:
            FlatlandError: there is no such service, or the call has failed.
        """

    def service_type(self, service: str) -> ServiceType:
        """The type of a service.

        Raises:
            BridgeError: there is no such service.
        """
        services = self.services
        if service not in services:
            hint = suggestion(service, services)
            raise BridgeError(f'there is no service "{service}"{hint}')
        return services[service]

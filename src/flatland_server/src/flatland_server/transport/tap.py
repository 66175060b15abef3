"""The interface of a recorder, which receives all messages of a `LocalTransport`."""

from abc import ABC, abstractmethod
from typing import Any

from flatland_server.geometry import Transform


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

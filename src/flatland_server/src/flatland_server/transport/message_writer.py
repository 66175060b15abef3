"""Makes messages from values, either as ROS message objects or directly in serialized form."""

from abc import ABC, abstractmethod
from typing import Any


class MessageWriter(ABC):
    """Makes the messages of one topic.

    Serializing a ROS message object field by field takes tens of microseconds, even if it has only
    a few numbers among constants. So a transport that sends bytes uses `data`, and one that keeps
    objects uses `message`. Both have the same contents.
    """

    @abstractmethod
    def message(self, *values: Any) -> Any:
        """The message as an object.

        Args:
            values: as the writer defines them.
        """

    @abstractmethod
    def data(self, *values: Any) -> bytes:
        """The serialized message. Each call increments the sequence number of the header.

        Args:
            values: the same as for `message`.
        """

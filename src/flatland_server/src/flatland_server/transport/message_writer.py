"""What makes messages of values: as objects, or at once as the bytes that ROS sends."""

from abc import ABC, abstractmethod
from typing import Any


class MessageWriter(ABC):
    """Makes the messages of one topic.

    A message of ROS is an object of many objects, and its generated code packs them one by one:
    tens of microseconds for what is a few numbers among constants. A transport that sends bytes
    asks for those, one that keeps messages asks for objects. Both say the same.
    """

    @abstractmethod
    def message(self, *values: Any) -> Any:
        """The message as an object."""

    @abstractmethod
    def data(self, *values: Any) -> bytes:
        """The message as bytes. The number of the header's sequence is one more each time."""

"""ROS messages that are serialized in advance."""

from typing import Any


class PreparedMessage:
    """A mixin for message classes, to be named before the class.

    Args:
        data: the serialized message.
    """

    def __init__(self, data: bytes) -> None:
        super().__init__()
        self._data = data

    def serialize(self, buff: Any) -> None:
        """Writes the message's bytes into a buffer; called by rospy."""
        buff.write(self._data)

"""Messages whose bytes are there already; rospy sends them as they are."""

from typing import Any


class PreparedMessage:
    """To be mixed in before a message's class.

    Args:
        data: the serialised message.
    """

    def __init__(self, data: bytes) -> None:
        super().__init__()
        self._data = data

    def serialize(self, buff: Any) -> None:
        """Writes the bytes."""
        buff.write(self._data)

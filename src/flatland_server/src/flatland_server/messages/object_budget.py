"""A limit to the objects that are made of received data, of which a few bytes may mean many."""

from typing import Any

from flatland_server.exceptions import MessageError

MOST_OBJECTS = 100_000
"""Messages within a message: some 20 MB."""


class ObjectBudget:
    """The objects that may still be made for a message.

    Args:
        most: greatest number of objects.
    """

    def __init__(self, most: int = MOST_OBJECTS) -> None:
        self._left = self._most = most

    def take(self, count: int) -> None:
        """Counts objects, before they are made.

        Raises:
            MessageError: there are too many.
        """
        self._left -= count
        if self._left < 0:
            raise MessageError(f"expected {self._most} messages within a message or fewer")


def objects_in(value: Any) -> int:
    """The messages and times that a default value is made of, and eighths of numbers in arrays."""
    if isinstance(value, (list, bytes)):
        return len(value) // 8 + sum(map(objects_in, value))
    if not hasattr(value, "__slots__"):
        return 0
    return 1 + sum(objects_in(getattr(value, name)) for name in value.__slots__)

"""Serialized messages of topics that may have other subscribers in this process.

rospy has one subscriber of a topic in a process, with the class of the `rospy.Subscriber` that came
first. One of rospy.AnyMsg leaves the others without fields, such as rospy's own one of /clock, and
after one of Clock those of AnyMsg get no bytes. Here both get what they expect, in any order: a raw
message reads its fields when they are asked for, and a message with fields is serialized again.
"""

from typing import Any, Callable

import rospy

from flatland_server.messages.message_types import deserialized, get
from flatland_server.messages.wire_form import serialized


class RawMessage(rospy.AnyMsg):  # type: ignore[misc]
    """A serialized message that has the fields of its type, too.

    Attributes:
        _buff: the bytes.
        _connection_header: of the publisher's connection; "type" is the message's type.
    """

    def __getattr__(self, name: str) -> Any:
        """Reads the fields, when the first of them is asked for."""
        if name.startswith("_"):
            raise AttributeError(name)
        message = deserialized(get(self._connection_header["type"]), self._buff)
        self.__dict__.update((each, getattr(message, each)) for each in message.__slots__)
        return getattr(message, name)


def subscribe(topic: str, receive: Callable[[RawMessage], None]) -> rospy.Subscriber:
    """Subscribes to messages of all types.

    Args:
        topic: name of the topic, with or without a leading "/".
        receive: called with each message, on a thread of rospy's.
    """

    def take(message: Any) -> None:
        receive(message if isinstance(message, RawMessage) else _raw(message))

    return rospy.Subscriber(topic, RawMessage, take)


def _raw(message: Any) -> RawMessage:
    raw = RawMessage()
    raw._buff = serialized(message)
    raw._connection_header = message._connection_header
    return raw

"""The calls of rospy that the server makes, by its public interface; patches replace most."""

import itertools
from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, ContextManager, Optional

import rospy

from flatland_server._core import BodyMessage, StepMessage
from flatland_server.messages.wire_form import LENGTH

if TYPE_CHECKING:
    from flatland_server.ros.rospy_patches.local_time import LocalTime


class SubscriberCounter(rospy.SubscribeListener):  # type: ignore[misc]
    """Counts how often subscribers have connected or disconnected. ROS's threads call it."""

    def __init__(self) -> None:
        self._counter = itertools.count(1)
        self.revision = 0

    def peer_subscribe(self, *_: Any) -> None:
        self.revision = next(self._counter)

    def peer_unsubscribe(self, *_: Any) -> None:
        self.revision = next(self._counter)


def is_connected(publisher: rospy.Publisher) -> bool:
    """True if a topic has a subscriber."""
    return bool(publisher.get_num_connections())


class _SerializedMessage(rospy.AnyMsg):  # type: ignore[misc]
    def __init__(self, data: bytes) -> None:
        super().__init__()
        self._data = data

    def serialize(self, buff: Any) -> None:
        buff.write(self._data)


class Outbox:
    """Holds messages back, so that many of a connection are sent in one call.

    This one holds nothing: rospy hands each message to a thread of the connection.

    Attributes:
        can_hold: whether it can hold messages back.
        is_open: whether messages that are published now wait for `send`; never if it cannot.
    """

    can_hold = False
    is_open = False

    def is_due(self) -> bool:
        """True if messages have waited long enough, or there are many."""
        return False

    def is_empty(self) -> bool:
        """True if no message waits."""
        return True

    def send(self) -> None:
        """Sends the messages that wait."""

    def step_message(
        self, publisher: rospy.Publisher, message: BodyMessage
    ) -> Optional[StepMessage]:
        """A message that the core writes to the present subscribers of a topic at each step.

        None: it cannot.
        """
        return None


def send_framed(publisher: rospy.Publisher, framed: bytes) -> None:
    """Publishes serialized messages, each preceded by its length."""
    begin = 0
    while begin < len(framed):
        (length,) = LENGTH.unpack_from(framed, begin)
        begin += LENGTH.size
        if publisher.get_num_connections():
            publisher.publish(_SerializedMessage(framed[begin : begin + length]))
        begin += length


_NO_OUTBOX = Outbox()


@dataclass(frozen=True)
class RospyCalls:
    """The operations of rospy that the server uses; by default, without any patch.

    Attributes:
        is_connected: returns whether a topic has a subscriber.
        send_framed: publishes one or more serialized messages, each preceded by its length; not for
            latched topics.
        outbox: holds the messages of connections back, if it can.
        batch_registration: within this context, topics and services may be registered with the
            master later, together, at its end.
        wait_until_registered: waits until the master knows of all topics and services, at most
            this long [s]; returns whether it does.
        take_over_time: returns the object that sets this process's time, from then on instead of
            rospy's own subscription to /clock; None if time is not simulated, or is left to rospy.
        forget_latched: makes a latched topic forget its last message, so that later subscribers do
            not get it. None: rospy cannot; a topic that needs it is not latched.
    """

    is_connected: Callable[[rospy.Publisher], bool] = is_connected
    send_framed: Callable[[rospy.Publisher, bytes], None] = send_framed
    outbox: Outbox = _NO_OUTBOX
    batch_registration: Callable[[], ContextManager[None]] = nullcontext
    wait_until_registered: Callable[[float], bool] = lambda limit: True
    take_over_time: Callable[[], "Optional[LocalTime]"] = lambda: None
    forget_latched: Optional[Callable[[rospy.Publisher], None]] = None

"""The calls of rospy that the server makes, by its public interface; patches replace most."""

import importlib
import itertools
import logging
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Callable, Collection, ContextManager, Dict, List, Optional

import rospy

from flatland_server._core import BodyMessage, StepMessage
from flatland_server.messages.wire_form import LENGTH
from flatland_server.ros.rospy_patches.rospy_checks import UnknownRospyError

if TYPE_CHECKING:
    from flatland_server.ros.rospy_patches.local_time import LocalTime

PATCHES: Dict[str, str] = {
    "nonblocking_connection": "each message costs two thread switches per subscriber; the last "
    "ones of a node may be lost",
    "registration": "worlds with many topics take longer to load; a master that hangs stops time",
    "tcpros_server": "a connection that sends nothing stops all services; subscribers may be "
    "delayed by seconds",
    "topic_polls": "each topic takes a file descriptor",
    "local_time": "this process receives its own /clock through a socket",
    "believed_lengths": "a message of a type with arrays of empty items may stop the process",
    "latched_topics": "the markers of models are not latched",
}
"""The modules of the patches, each with what it costs to do without it.

Two of them save time. A step of the office at 200 Hz takes 0.19 ms of processor time while a scan
and odometry are subscribed to, 0.27 ms without `local_time`, and 0.40 ms or more without
`nonblocking_connection`. The others have a test that fails without them.
"""

logger = logging.getLogger(__name__)


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


def install(names: Collection[str] = tuple(PATCHES)) -> RospyCalls:
    """Puts patches in place that this rospy allows; logs those that it does not.

    To be called after `rospy.init_node` and before any topic is opened.

    Args:
        names: of the patches; none: rospy is left as it is.

    Returns:
        The operations to use, each patched or plain.
    """
    if not names:
        logger.info("rospy is not patched: publishing and loading take longer")
        return RospyCalls()
    calls = RospyCalls()
    refused: List[str] = []
    for name in names:
        try:
            module = importlib.import_module(f"{__package__}.{name}")
            calls = replace(calls, **module.install())
        except (ImportError, AttributeError, OSError, UnknownRospyError) as error:
            refused.append(f"{name} ({error}): {PATCHES[name]}")
    if refused:
        logger.warning("patches of rospy that are switched off: %s", "; ".join(refused))
    return calls

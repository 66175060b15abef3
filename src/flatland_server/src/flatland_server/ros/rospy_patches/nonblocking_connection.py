"""Sends messages at once if the subscriber's socket has room for them.

rospy hands every message to a thread of the connection. This costs two thread switches under
Python's global lock: more than the rest of the work for a small message, hundreds of times a
second. Here the queue of a connection is the core's (`SubscriberQueue`): the publishing thread
writes to the socket itself, as long as that does not block. A subscriber that does not keep up
receives the rest from a thread of the core, as soon as its socket has room. It loses the oldest
messages of a full queue, as with rospy alone: it never delays the simulation.

A call of the system takes as long as several steps of a small world. So while steps follow each
other without a wait, the outbox is open: messages wait at their connections, in their order, until
`HeldMessages.send`. The loop calls it when the first of them has waited for `PERIOD`, when a
connection has `MOST` messages, before it waits, runs callbacks or answers a request for steps, and
when it ends. These calls come at the ends of steps: a step that takes longer than `PERIOD` delays
them. At real time the loop waits after each step, and no message is held back. A socket gets all
that waits for it in one call.
"""

import os
import socket
from typing import Any, Dict, List, Optional

import rospy
import rospy.topics
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_pubsub import QueuedConnection

from flatland_server._core import BodyMessage, StepMessage, SubscriberQueue
from flatland_server._core import Outbox as CoreOutbox
from flatland_server.ros.rospy_patches.rospy_calls import Outbox
from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

PERIOD = 0.005
"""Real time that a message is held back at most, but for the end of a long step [s]."""

MOST = 10
"""Messages of a connection that are held back at most, but for those of one step.

Subscribers with shorter queues may lose some of them, as they may when steps follow fast anyway.
"""

BUFFER = 64 * 1024
"""Bytes that the system keeps for a subscriber, twice, before its socket counts as full.

Linux would let them grow to megabytes. A subscriber that messages flood, as at full speed with a
hundred robots, would read what is long past, and connect to other topics after a minute.
"""

PATIENCE = 0.05
"""Real time for which more messages than a publisher's `queue_size` may wait for a subscriber [s].

At a hundred times real time there are 20,000 odometries a second: ten would wait for half of a
millisecond, and a subscriber that keeps up may not be run for several.
"""

_CONNECTION = "rospy.impl.tcpros_pubsub:QueuedConnection"

REQUIREMENTS = (
    Requirement("rospy.topics:QueuedConnection", ("connection", "queue_size")),
    Requirement("rospy.topics:_PublisherImpl.add_connection", uses=("QueuedConnection",)),
    Requirement("rospy.topics:Topic.__init__", uses=("impl",)),
    Requirement("rospy.topics:_TopicImpl.__init__", uses=("connections", "closed")),
    Requirement("rospy.topics:_TopicImpl.remove_connection", ("self", "c")),
    Requirement("rospy.topics:_TopicManager.__init__", uses=("pubs",)),
    Requirement(f"{_CONNECTION}.__init__", uses=("_connection", "_run")),
    Requirement(f"{_CONNECTION}._closed_connection_callback", ("self", "connection")),
    Requirement(f"{_CONNECTION}.write_data", ("self", "data")),
    Requirement(f"{_CONNECTION}._run", ("self",)),
    Requirement("rospy.impl.tcpros_base:TCPROSTransport.__init__", uses=("socket",)),
)


def install() -> Dict[str, Any]:
    """Makes publishers use `NonblockingConnection` for new subscribers.

    Returns the calls that this replaces.
    """
    check_all(REQUIREMENTS)
    rospy.topics.QueuedConnection = NonblockingConnection
    return {"is_connected": is_connected, "send_framed": send_framed, "outbox": outbox}


def is_connected(publisher: rospy.Publisher) -> bool:
    """True if a topic has a subscriber; without rospy's lock."""
    topic = publisher.impl
    return topic is not None and bool(topic.connections)


def send_framed(publisher: rospy.Publisher, framed: bytes) -> None:
    """Publishes one or more serialized messages, each preceded by its length.

    `rospy.Publisher.publish` would take a lock, copy each through a buffer and count it.
    """
    topic = publisher.impl
    if topic is None or topic.closed:
        return
    for connection in topic.connections:
        try:
            connection.write_data(framed)
        except Exception:  # like rospy's own publish: a connection that fails is dropped
            connection.close()
            topic.remove_connection(connection)


class HeldMessages(Outbox):
    """The messages that wait, of all connections."""

    can_hold = True

    def __init__(self, period: float = PERIOD) -> None:
        self.core = CoreOutbox(period, MOST)
        self.is_due, self.is_empty = self.core.is_due, self.core.is_empty  # asked in each step

    def send(self) -> None:
        if not self.core.is_empty() and not self.core.send():
            _drop_failed()

    def step_message(
        self, publisher: rospy.Publisher, message: BodyMessage
    ) -> Optional[StepMessage]:
        topic = publisher.impl
        connections = topic.connections if topic is not None else []
        if not all(isinstance(each, NonblockingConnection) for each in connections):
            return None
        return StepMessage(message, self.core, [each.queue for each in connections])


outbox = HeldMessages()
"""That of the publishers of this process, on all threads."""


class NonblockingConnection(QueuedConnection):
    """A connection to a subscriber, with the interface that rospy's publishers use."""

    def __init__(self, connection: Any, queue_size: int) -> None:
        connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)
        self.queue = SubscriberQueue(connection.socket.fileno(), queue_size, PATIENCE)
        super().__init__(connection, queue_size)

    def write_data(self, data: bytes) -> bool:
        """Sends a message, holds it back, or queues it if the socket is full.

        Raises:
            TransportTerminated: the connection is closed.
        """
        queue = self.queue
        if not (outbox.core.add(queue, data) if outbox.is_open else queue.send(data)):
            self._connection.close()
            raise TransportTerminated(os.strerror(queue.error))
        return True

    @property
    def stat_bytes(self) -> int:
        """Number of bytes sent."""
        return self.queue.bytes_sent

    @property
    def stat_num_msg(self) -> int:
        """Number of messages sent."""
        return self.queue.messages_sent

    def _closed_connection_callback(self, connection: Any) -> None:
        self.queue.close()

    def _run(self) -> None:
        """Ends rospy's thread of the connection: a thread of the core sends what is left."""


def _drop_failed() -> None:
    """Closes the connections that have failed, and removes them from their topics."""
    topics: List[Any] = list(rospy.topics.get_topic_manager().pubs.values())
    for topic in topics:
        for connection in topic.connections:
            if isinstance(connection, NonblockingConnection) and connection.queue.error:
                connection.close()
                topic.remove_connection(connection)

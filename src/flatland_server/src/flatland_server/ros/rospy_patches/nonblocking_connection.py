"""Sends messages at once if the subscriber's socket has room for them.

rospy hands every message to a thread of the connection. This costs two thread switches under
Python's global lock: more than the rest of the work for a small message, hundreds of times a
second. Here the publishing thread writes to the socket itself, as long as that does not block. A
subscriber that does not keep up receives the rest later, as soon as its socket has room: from the
publishing thread with the next message, or from rospy's thread. It loses the oldest messages of a
full queue, as with rospy alone: it never delays the simulation.

A call of the system takes as long as several steps of a small world. So while steps follow each
other without a wait, the outbox is open: messages wait at their connections, in their order, until
`HeldMessages.send`. The loop calls it when the first of them has waited for `PERIOD`, when a
connection has `MOST` messages, before it waits, runs callbacks or answers a request for steps, and
when it ends. These calls come at the ends of steps: a step that takes longer than `PERIOD` delays
them. At real time the loop waits after each step, and no message is held back. A socket gets all
that waits for it in one call.
"""

import math
import select
import socket
import time
from collections import deque
from typing import Any, Deque, Dict, List

import rospy.topics
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_pubsub import QueuedConnection

from flatland_server.ros.rospy_patches.public_rospy import Outbox
from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

PERIOD = 0.005
"""Real time that a message is held back at most, but for the end of a long step [s]."""

MOST = 10
"""Messages of a connection that are held back at most, but for those of one step.

Subscribers with shorter queues may lose some of them, as they may when steps follow fast anyway.
"""

_MOST_BUFFERS = 500
"""Messages in one call; Linux takes 1,024 pieces."""

_CHECK_PERIOD = 1000
"""Time between two checks whether a connection with a full socket is closed [ms]."""

_CONNECTION = "rospy.impl.tcpros_pubsub:QueuedConnection"

REQUIREMENTS = (
    Requirement("rospy.topics:QueuedConnection", ("connection", "queue_size")),
    Requirement("rospy.topics:_PublisherImpl.add_connection", uses=("QueuedConnection",)),
    Requirement(
        f"{_CONNECTION}.__init__",
        uses=(
            "_connection",
            "_queue_size",
            "_lock",
            "_cond_data_available",
            "_queue",
            "_error",
            "_run",
        ),
    ),
    Requirement(f"{_CONNECTION}.write_data", ("self", "data")),
    Requirement(f"{_CONNECTION}._run", ("self",)),
    Requirement("rospy.impl.tcpros_base:TCPROSTransport.__init__", uses=("socket",)),
    Requirement(
        "rospy.impl.transport:Transport.__init__", uses=("done", "stat_bytes", "stat_num_msg")
    ),
)


def install() -> Dict[str, Any]:
    """Makes publishers use `NonblockingConnection` for new subscribers.

    Returns the calls that this replaces.
    """
    check_all(REQUIREMENTS)
    rospy.topics.QueuedConnection = NonblockingConnection
    return {"outbox": outbox}


class HeldMessages(Outbox):
    """The connections with messages that wait, in the order of their first ones."""

    def __init__(self) -> None:
        self.is_full = False
        self._connections: Deque[NonblockingConnection] = deque()
        self._due = math.inf  # real time [s]

    def open(self) -> None:
        self.is_open = True

    def add(self, connection: "NonblockingConnection") -> None:
        """Notes a connection that has got its first message; ROS's threads may call it, too."""
        if not self._connections:
            self._due = time.monotonic() + PERIOD
        self._connections.append(connection)

    @property
    def is_due(self) -> bool:
        return self.is_full or (bool(self._connections) and time.monotonic() >= self._due)

    def send(self) -> None:
        self.is_full = False
        while self._connections:
            self._connections.popleft().send_held()


outbox = HeldMessages()
"""That of all connections of this process."""


class NonblockingConnection(QueuedConnection):
    """A connection to a subscriber, with the interface that rospy's publishers use."""

    def __init__(self, connection: Any, queue_size: int) -> None:
        self._held: List[bytes] = []  # messages that wait for the outbox
        self._unsent = b""  # the rest of a message that is sent in part
        super().__init__(connection, queue_size)

    def write_data(self, data: bytes) -> bool:
        """Sends a message, holds it back, or queues it if the socket is full.

        Raises:
            TransportTerminated: the connection is closed.
        """
        try:
            with self._lock:
                if self._error:
                    error, self._error = self._error, None
                    raise error
                held = self._held
                held.append(data)
                if not outbox.is_open:
                    self._send_or_queue()
                elif len(held) == 1:
                    outbox.add(self)
                elif len(held) >= MOST:
                    outbox.is_full = True
        except OSError as error:
            self._connection.close()  # which takes the lock
            raise TransportTerminated(str(error)) from None
        return True

    def send_held(self) -> None:
        """Sends the messages that are held back. The next `write_data` raises its exception."""
        with self._lock:
            try:
                self._send_or_queue()
            except (OSError, TransportTerminated) as error:
                self._fail(error)

    def _send_or_queue(self) -> None:
        held, self._held = self._held, []
        self._queue += held
        self._send_queue()
        if self._queue_size > 0:
            del self._queue[: -self._queue_size]
        if self._unsent or self._queue:
            self._cond_data_available.notify()

    def _send_queue(self) -> None:
        """Sends what is queued, as far as the socket takes it without blocking."""
        waiting = [self._unsent, *self._queue] if self._unsent else self._queue
        if not waiting:
            return
        connection = self._connection
        if connection.socket is None:
            raise TransportTerminated("connection closed")
        try:
            sent: int = connection.socket.sendmsg(waiting[:_MOST_BUFFERS], (), socket.MSG_DONTWAIT)
        except BlockingIOError:
            return
        connection.stat_bytes += sent
        count = 0
        while count < len(waiting) and sent >= len(waiting[count]):
            sent -= len(waiting[count])
            count += 1
        connection.stat_num_msg += count
        self._unsent = waiting[count][sent:] if sent else b""
        self._queue = waiting[count + 1 if sent else count :]

    def _fail(self, error: Exception) -> None:
        """Drops what is queued; the next `write_data` raises the error."""
        self._error, self._unsent, self._queue = error, b"", []

    def _run(self) -> None:
        connection = self._connection
        while not connection.done:
            with self._lock:
                while not self._unsent and not self._queue and not connection.done:
                    self._cond_data_available.wait()
            self._wait_for_room()
            with self._lock:
                try:
                    self._send_queue()
                except (OSError, TransportTerminated) as error:
                    self._fail(error)

    def _wait_for_room(self) -> None:
        """Waits until the socket takes more, or has failed, but not for long."""
        end = self._connection.socket
        if end is not None and end.fileno() >= 0:
            poll = select.poll()
            poll.register(end, select.POLLOUT)
            poll.poll(_CHECK_PERIOD)

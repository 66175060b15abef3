"""Sends a message at once if the subscriber's socket has room for it.

rospy hands every message to a thread of the connection. This costs two thread switches under
Python's global lock: more than the rest of the work for a small message, hundreds of times a
second. Here the publishing thread writes to the socket itself, as long as that does not block. A
subscriber that does not keep up receives what follows from rospy's thread, and loses the oldest
messages of a full queue, as with rospy alone: it never delays the simulation.

A call of the system takes as long as several steps of a small world. So while steps follow each
other without a wait, the outbox is open: messages wait at their connections, in their order, until
`HeldMessages.send`. The loop calls it when the first of them has waited for `PERIOD`, when a
connection has `MOST` messages, before it waits, runs callbacks or answers a request for steps, and
when it ends. These calls come at the ends of steps: a step that takes longer than `PERIOD` delays
them. At real time the loop waits after each step, and no message is held back. `send` gives a
socket all that waits for it in one call; a message that does not fit, and those after it, are
treated one by one as above.
"""

import math
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
        self._unsent = b""  # data that the thread is sending, or must send first
        super().__init__(connection, queue_size)

    def write_data(self, data: bytes) -> bool:
        """Sends a message, holds it back, or queues it for the thread if the socket is full.

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
                self._error = error

    def _send_or_queue(self) -> None:
        messages, self._held = self._held, []
        if not messages:
            return
        if not self._unsent and not self._queue:
            messages = self._send_now(messages)
            if not messages:
                return
            self._unsent = messages.pop(0)
        for data in messages:
            if 0 < self._queue_size == len(self._queue):
                del self._queue[0]
            self._queue.append(data)
        self._cond_data_available.notify()

    def _send_now(self, messages: List[bytes]) -> List[bytes]:
        """Sends as much as the socket takes without blocking; returns the rest."""
        connection = self._connection
        if connection.socket is None:
            raise TransportTerminated("connection closed")
        try:
            sent: int = connection.socket.send(b"".join(messages), socket.MSG_DONTWAIT)
        except BlockingIOError:
            return messages
        connection.stat_bytes += sent
        for i, data in enumerate(messages):
            if sent < len(data):
                return [data[sent:], *messages[i + 1 :]]
            sent -= len(data)
            connection.stat_num_msg += 1
        return []

    def _run(self) -> None:
        connection = self._connection
        while not connection.done:
            with self._lock:
                while not self._unsent and not self._queue and not connection.done:
                    self._cond_data_available.wait()
                if not self._unsent and self._queue:
                    self._unsent = self._queue.pop(0)
            if self._unsent:
                try:
                    connection.write_data(self._unsent)
                except Exception as error:
                    with self._lock:
                        self._error = error
                with self._lock:
                    self._unsent = b""

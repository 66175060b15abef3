"""Sends a message at once if the subscriber's socket has room for it.

rospy hands every message to a thread of the connection. This costs two thread switches under
Python's global lock: more than the rest of the work for a small message, hundreds of times a
second. Here the publishing thread writes to the socket itself, as long as that does not block. A
subscriber that does not keep up receives what follows from rospy's thread, and loses the oldest
messages of a full queue, as with rospy alone: it never delays the simulation.
"""

import socket
from typing import Any, Dict

import rospy.topics
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_pubsub import QueuedConnection

from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

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
    """Makes publishers use `NonblockingConnection` for new subscribers. Replaces no call."""
    check_all(REQUIREMENTS)
    rospy.topics.QueuedConnection = NonblockingConnection
    return {}


class NonblockingConnection(QueuedConnection):
    """A connection to a subscriber, with the interface that rospy's publishers use."""

    def __init__(self, connection: Any, queue_size: int) -> None:
        self._unsent = b""  # data that the thread is sending, or must send first
        super().__init__(connection, queue_size)

    def write_data(self, data: bytes) -> bool:
        """Sends a message, or queues it for the thread if it does not fit into the socket now.

        Raises:
            TransportTerminated: the connection is closed.
        """
        try:
            with self._lock:
                self._send_or_queue(data)
        except OSError as error:
            self._connection.close()  # which takes the lock
            raise TransportTerminated(str(error)) from None
        return True

    def _send_or_queue(self, data: bytes) -> None:
        if self._error:
            error, self._error = self._error, None
            raise error
        if not self._unsent and not self._queue:
            sent = self._send_now(data)
            if sent == len(data):
                return
            self._unsent = data[sent:]
        else:
            if 0 < self._queue_size == len(self._queue):
                del self._queue[0]
            self._queue.append(data)
        self._cond_data_available.notify()

    def _send_now(self, data: bytes) -> int:
        """Returns how many bytes the socket has taken without blocking."""
        connection = self._connection
        if connection.socket is None:
            raise TransportTerminated("connection closed")
        try:
            sent: int = connection.socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return 0
        if sent == len(data):
            connection.stat_bytes += sent
            connection.stat_num_msg += 1
        return sent

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

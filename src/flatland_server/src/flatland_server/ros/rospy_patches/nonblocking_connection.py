"""Sending at once what a listener has room for.

rospy hands every message to a thread of its connection, which costs two changes of threads under
Python's lock: more than all the rest of a small message, hundreds of times a second. Here the
publishing thread writes to the socket itself, as long as that does not have to wait. A listener
that does not keep up gets what follows from rospy's thread, and loses the oldest of a full queue,
as before: it never holds the simulation up.
"""

import socket
import struct
from typing import Any

import rospy.topics
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_pubsub import QueuedConnection

_LENGTH = struct.Struct("<I")


def use_nonblocking_connections() -> None:
    """Lets publishers of this process send so. To be called before there are any."""
    rospy.topics.QueuedConnection = NonblockingConnection


def send_bytes(publisher: rospy.Publisher, data: bytes) -> None:
    """Publishes a serialised message, without the detour over an object. Not for latched topics."""
    send_framed(publisher, _LENGTH.pack(len(data)) + data)


def send_framed(publisher: rospy.Publisher, framed: bytes) -> None:
    """The same with one message or several that have their lengths before them."""
    topic = publisher.impl
    if topic is None or topic.closed:
        return
    for connection in topic.connections:
        try:
            connection.write_data(framed)
        except Exception:  # as rospy's own publish: who cannot be sent to is listened to no more
            connection.close()
            topic.remove_connection(connection)


class NonblockingConnection(QueuedConnection):
    """A connection to a listener, as rospy's publishers use it."""

    def __init__(self, connection: Any, queue_size: int) -> None:
        self._unsent = b""  # what the thread is sending, or has to send first
        super().__init__(connection, queue_size)

    def write_data(self, data: bytes) -> bool:
        """Sends a message, or leaves it to the thread if it does not fit into the socket now.

        Raises:
            TransportTerminated: the listener is gone.
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
        """How many bytes the socket has taken without waiting."""
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

"""Accepts connections so that none of them holds up the others.

rospy's server for topics and services has one thread that accepts a connection, and then reads its
header (the handshake of TCPROS) before it accepts the next. Three things stop it:

- A connection that sends nothing: no service is answered any more, no topic gets a subscriber.
  Here headers are waited for together, each for a limited time.
- Too many open files: the thread ends with an exception. Here it waits until one is closed.
- Many connections at once: only five may wait to be accepted; the system retries the others after
  one second, two seconds, four seconds etc. Here a thousand may wait.

A subscriber that connects to a topic that has just been removed, with its model or its world, is
refused. rospy warns of each, and lists all topics; here only the subscriber gets the error.
"""

import errno
import logging
import selectors
import socket
import threading
import time
from typing import Any, Callable, Dict, List, Tuple

from rospy.impl import registration, tcpros_base

from flatland_server.messages.wire_form import LENGTH
from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

REQUIREMENTS = (
    Requirement("rospy.impl.tcpros_base:start_tcpros_server", ()),
    Requirement("rospy.impl.tcpros_base:_tcpros_server"),
    Requirement("rospy.impl.tcpros_base:TCPROSServer.__init__", uses=("tcp_ros_server",)),
    Requirement(
        "rospy.impl.tcpros_base:TCPServer.__init__", uses=("server_sock", "inbound_handler")
    ),
    Requirement(
        "rospy.impl.tcpros_base:TCPServer.run", uses=("server_sock", "accept", "inbound_handler")
    ),
    Requirement(
        "rospy.impl.tcpros_base:TCPROSServer._tcp_server_callback",
        ("self", "sock", "client_addr"),
        uses=("read_ros_handshake_header", "topic_connection_handler"),
    ),
    Requirement("rospy.impl.tcpros_base:write_ros_handshake_header", ("sock", "header")),
    Requirement("rospy.topics:_TopicManager.get_publisher_impl", ("self", "resolved_name")),
)

BACKLOG = 1024
"""Connections that may wait to be accepted; the system may allow fewer."""
HANDSHAKE_LIMIT = 10.0
"""Real time that a connection has to send its header [s]."""
_LARGEST_HEADER = 1 << 20
"""Bytes. A subscriber's header holds the definition of the message's type."""
_RETRY_PERIOD = 0.1  # s
_NO_FILES = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)

logger = logging.getLogger(__name__)

Handler = Callable[[socket.socket, Any], None]
TopicHandler = Callable[[socket.socket, Any, Dict[str, str]], Any]


def install() -> Dict[str, Any]:
    """Changes rospy's server, which it starts if need be. Replaces no call."""
    check_all(REQUIREMENTS)
    tcpros_base.start_tcpros_server()  # as the first subscriber would
    rospys = tcpros_base._tcpros_server
    rospys.topic_connection_handler = refusing_removed_topics(rospys.topic_connection_handler)
    server = rospys.tcp_ros_server
    listening = server.server_sock
    listening.listen(BACKLOG)
    server.inbound_handler = Handshakes(server.inbound_handler).add
    server.server_sock = _PatientSocket(listening)
    # The thread waits in `accept` of the former socket: this connection takes it out.
    socket.create_connection(listening.getsockname()[:2], 1.0).close()
    return {}


def refusing_removed_topics(handle: TopicHandler) -> TopicHandler:
    """Refuses subscribers of topics that are not published; leaves all others to rospy."""

    def handle_topic(connection: socket.socket, address: Any, header: Dict[str, str]) -> Any:
        topic = header["topic"]
        publisher = registration.get_topic_manager().get_publisher_impl(topic)
        if publisher is not None and not publisher.closed:
            return handle(connection, address, header)
        logger.debug("%s asked for %s, which is not published", header.get("callerid"), topic)
        error = {"error": f"{topic} is not published"}
        tcpros_base.write_ros_handshake_header(connection, error)
        connection.close()
        return None

    return handle_topic


class _PatientSocket:
    """A listening socket that waits while there are no file descriptors for a connection."""

    def __init__(self, listening: socket.socket) -> None:
        self._listening = listening

    def accept(self) -> Tuple[socket.socket, Any]:
        has_warned = False
        while True:
            try:
                return self._listening.accept()
            except OSError as error:
                if error.errno not in _NO_FILES:
                    raise
                if not has_warned:
                    logger.error("connections have to wait: %s (see ulimit -n)", error.strerror)
                    has_warned = True
                time.sleep(_RETRY_PERIOD)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._listening, name)


class _Handshake:
    """A connection that has not sent its header yet.

    Attributes:
        deadline: when it is given up, by `time.monotonic()`.
    """

    def __init__(self, connection: socket.socket, address: Any) -> None:
        self.connection = connection
        self.address = address
        self.deadline = time.monotonic() + HANDSHAKE_LIMIT
        self._size = 0
        self._expect(LENGTH.size)

    def _expect(self, size: int) -> None:
        """Makes the socket count as readable only when it holds this many bytes, or has ended."""
        self._size = size
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, size)

    def is_complete(self) -> bool:
        """True if the header has arrived; it is left in the socket.

        Raises:
            OSError: the connection has ended, or its header is too large.
        """
        data = self.connection.recv(self._size, socket.MSG_PEEK | socket.MSG_DONTWAIT)
        if len(data) < self._size:
            raise ConnectionAbortedError("it ended before its header was complete")
        if self._size > LENGTH.size:
            self._expect(1)
            return True
        (length,) = LENGTH.unpack(data)
        if length > _LARGEST_HEADER:
            raise OSError(f"its header has {length} bytes, more than {_LARGEST_HEADER}")
        self._expect(LENGTH.size + length)
        return length == 0


class Handshakes:
    """Waits for the headers of connections, and passes on those that have sent theirs.

    Args:
        handle: called with a connection and its address, on a thread of this object's. It reads
            the header.
    """

    def __init__(self, handle: Handler) -> None:
        self._handle = handle
        self._added: List[Tuple[socket.socket, Any]] = []
        self._selector = selectors.DefaultSelector()
        self._waker, woken = socket.socketpair()
        self._woken = woken
        self._woken.setblocking(False)
        self._selector.register(woken, selectors.EVENT_READ)
        threading.Thread(target=self._run, name="handshakes", daemon=True).start()

    def add(self, connection: socket.socket, address: Any) -> None:
        """Takes over a connection."""
        self._added.append((connection, address))
        self._waker.send(b"+")

    def _run(self) -> None:
        while True:
            for key, _ in self._selector.select(self._time_left()):
                if key.data is None:
                    self._woken.recv(4096)
                else:
                    self._advance(key.data)
            while self._added:
                self._begin(*self._added.pop(0))
            self._give_up()

    def _waiting(self) -> List[_Handshake]:
        return [key.data for key in self._selector.get_map().values() if key.data is not None]

    def _time_left(self) -> Any:
        deadlines = [handshake.deadline for handshake in self._waiting()]
        return max(0.0, min(deadlines) - time.monotonic()) if deadlines else None

    def _begin(self, connection: socket.socket, address: Any) -> None:
        try:
            handshake = _Handshake(connection, address)
            self._selector.register(connection, selectors.EVENT_READ, handshake)
        except OSError as error:
            logger.warning("a connection from %s fails: %s", address, error)
            connection.close()

    def _advance(self, handshake: _Handshake) -> None:
        try:
            if not handshake.is_complete():
                return
        except OSError as error:
            self._close(handshake, str(error))
            return
        self._selector.unregister(handshake.connection)
        try:
            self._handle(handshake.connection, handshake.address)
        except Exception as error:  # rospy's own handler catches most
            logger.warning("a connection from %s fails: %s", handshake.address, error)
            handshake.connection.close()

    def _give_up(self) -> None:
        now = time.monotonic()
        late = [handshake for handshake in self._waiting() if handshake.deadline <= now]
        for handshake in late:
            self._close(handshake, "it sent no header in time")
        if late:
            logger.warning(
                "%d connections sent no header within %g s and are closed; the last is from %s",
                len(late),
                HANDSHAKE_LIMIT,
                late[-1].address,
            )

    def _close(self, handshake: _Handshake, reason: str) -> None:
        logger.debug("a connection from %s is closed: %s", handshake.address, reason)
        self._selector.unregister(handshake.connection)
        handshake.connection.close()

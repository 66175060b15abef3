"""Publishers of topics by sockets alone: they need no node of one's own."""

import socket
import struct
import threading
from types import TracebackType
from typing import Any, Dict, List, Optional, Tuple, Type
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

import roslib.message
import tcpros_client
from rosgraph.network import encode_ros_handshake_header

from flatland_server.messages.wire_form import serialized

CALLER = "/test_publisher"


class _QuietHandler(SimpleXMLRPCRequestHandler):
    rpc_paths = ("/", "/RPC2")

    def log_message(self, *_: Any) -> None:
        pass


class Publishers:
    """Publishers of several topics, as a context manager.

    Args:
        master: with `ask`, to register them at.
        types: message types by topic.
    """

    def __init__(self, master: Any, types: Dict[str, str]) -> None:
        self._master = master
        self._types = types
        self._connections: Dict[str, List[socket.socket]] = {topic: [] for topic in types}
        self._api = SimpleXMLRPCServer(("127.0.0.1", 0), _QuietHandler, allow_none=True)
        self._api.register_function(self._request_topic, "requestTopic")
        self._socket = socket.create_server(("127.0.0.1", 0))
        self._threads = [
            threading.Thread(target=self._api.serve_forever, daemon=True),
            threading.Thread(target=self._accept, daemon=True),
        ]

    def __enter__(self) -> "Publishers":
        for thread in self._threads:
            thread.start()
        for topic, message_type in self._types.items():
            self._master.ask("registerPublisher", topic, message_type, self._uri, caller=CALLER)
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        traceback: Optional[TracebackType],
    ) -> None:
        for topic in self._types:
            self._master.ask("unregisterPublisher", topic, self._uri, caller=CALLER)
        self._api.shutdown()
        self._api.server_close()
        self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        for thread in self._threads:
            thread.join()
        for connections in self._connections.values():
            for connection in connections:
                connection.close()

    @property
    def _uri(self) -> str:
        return f"http://127.0.0.1:{self._api.server_address[1]}/"

    def has_subscribers(self, topic: str) -> bool:
        """True if a subscriber is connected."""
        return bool(self._connections[topic])

    def send(self, topic: str, message: Any) -> None:
        """Sends a message to all subscribers of a topic; forgets those that have gone."""
        data = serialized(message)
        for connection in list(self._connections[topic]):
            try:
                connection.sendall(struct.pack("<I", len(data)) + data)
            except ConnectionError:
                self._connections[topic].remove(connection)
                connection.close()

    def _request_topic(self, _caller: str, topic: str, _protocols: Any) -> Tuple[int, str, Any]:
        return 1, "ready", ["TCPROS", *self._socket.getsockname()]

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return
            topic = tcpros_client.read_header(connection)["topic"]
            message = roslib.message.get_message_class(self._types[topic])
            header = {
                **{"callerid": CALLER, "topic": topic, "type": message._type},
                **{"md5sum": message._md5sum, "message_definition": message._full_text},
            }
            connection.sendall(encode_ros_handshake_header(header))
            self._connections[topic].append(connection)

"""Services and topics of a node, by sockets alone: they need no master and no node of one's own."""

import socket
import struct
import xmlrpc.client
from typing import Any, Dict, Tuple
from urllib.parse import urlparse

from rosgraph.network import decode_ros_handshake_header, encode_ros_handshake_header

from flatland_server.messages.wire_form import serialized

LIMIT = 20.0  # s
_LENGTH = struct.Struct("<I")


def open_connection(address: Tuple[str, int], **fields: str) -> socket.socket:
    """A TCPROS connection after the handshake."""
    connection = socket.create_connection(address, LIMIT)
    header: Dict[str, str] = {"callerid": "/test", "md5sum": "*", **fields}
    connection.sendall(encode_ros_handshake_header(header))
    read_block(connection)  # the node's header
    return connection


def read_header(connection: socket.socket) -> Dict[str, str]:
    """The fields with which the other side begins a connection."""
    data = read_block(connection)
    fields: Dict[str, str] = decode_ros_handshake_header(_LENGTH.pack(len(data)) + data)
    return fields


def read_block(connection: socket.socket) -> bytes:
    """Reads a block that begins with its length in four bytes."""
    (length,) = _LENGTH.unpack(_read(connection, _LENGTH.size))
    return _read(connection, length)


def _read(connection: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        more = connection.recv(size - len(data))
        if not more:
            raise ConnectionError(f"the node closed the connection after {len(data)} bytes")
        data += more
    return data


def call_service(uri: str, service_name: str, service: Any, **request: Any) -> Any:
    """The response of a service at a URI, as `rosrpc://127.0.0.1:1234`."""
    place = urlparse(uri)
    with open_connection((place.hostname, place.port), service=service_name) as connection:
        connection.sendall(request_bytes(service, **request))
        is_done = _read(connection, 1)
        data = read_block(connection)
    if is_done != b"\x01":
        raise ConnectionError(data.decode())
    response: Any = service._response_class()
    response.deserialize(data)
    return response


def request_bytes(service: Any, **request: Any) -> bytes:
    """A request of a service after its length, as it is sent after the handshake."""
    data = serialized(service._request_class(**request))
    return _LENGTH.pack(len(data)) + data


def subscribe(node_uri: str, topic: str, message_type: Any) -> socket.socket:
    """A connection on which the messages of a node's topic arrive; see `next_message`."""
    node = xmlrpc.client.ServerProxy(node_uri)
    code, status, answer = node.requestTopic("/test", topic, [["TCPROS"]])  # type: ignore[misc]
    assert code == 1, status
    return open_connection((answer[1], answer[2]), topic=topic, type=message_type._type)


def next_message(connection: socket.socket, message_type: Any) -> Any:
    """The next message of a topic."""
    message: Any = message_type()
    message.deserialize(read_block(connection))
    return message

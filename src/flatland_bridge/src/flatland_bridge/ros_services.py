"""The services of a ROS master: their types, which only their servers know, and calls of them.

rospy's own calls wait for the master and for the server without a limit.
"""

import math
import socket
import threading
import time
from typing import Any, Dict, List, NamedTuple, Optional, Tuple
from urllib.parse import urlparse

import rospy
from rosgraph.network import (
    ROSHandshakeException,
    decode_ros_handshake_header,
    encode_ros_handshake_header,
)

from flatland_bridge.client_calls import client_is_gone
from flatland_bridge.graph import BridgeError
from flatland_server.exceptions import MessageError
from flatland_server.messages import LENGTH, WRONG_VALUE, deserialized, serialized, service_types
from flatland_server.ros.rospy_patches import master_calls

_ANSWER_LIMIT = 5.0
"""Real time that a server has to answer the header of a connection [s]."""
_RETRY_PERIOD = 5.0
"""Real time after which a server that has not answered is asked again [s]."""
_PATIENCE = 1.0
"""Real time that `follow` waits for servers, most of which answer within milliseconds [s]."""
_LOOK_PERIOD = 0.5  # s of real time: an answer is waited for until the node ends, or the caller
_LARGEST_HEADER = 1 << 20  # bytes
_NO_ANSWER = (OSError, ROSHandshakeException, ValueError)

Registration = Tuple[str, str]
"""The name of a service, and the URI of its node, which changes when the node is restarted."""


class Service(NamedTuple):
    """A service, and the URI of its server; without a type, if that is not known here."""

    uri: str
    type: Optional[service_types.ServiceType]


class RosServices:
    """Asks each server on a thread of its own: one that is stopped or gone delays no other."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._services: Dict[Registration, Service] = {}
        self._pauses: Dict[str, float] = {}  # until when a server is not asked, by its URI

    def follow(self, registrations: List[Registration], master: master_calls.Master) -> None:
        """Asks for the types of services that are new, or of servers that did not answer before.

        Args:
            registrations: the services that are registered at the master.
            master: master to ask for the URIs of the services.

        Raises:
            NO_ANSWER: one of these, by the master.
        """
        with self._lock:
            known = set(registrations)
            self._services = {key: each for key, each in self._services.items() if key in known}
            new = {key[0]: key for key in registrations if key not in self._services}
        servers: Dict[str, List[Registration]] = {}
        for name, uri in (master.uris(new, "lookupService") if new else {}).items():
            servers.setdefault(uri, []).append(new[name])
        now = time.monotonic()
        with self._lock:
            self._pauses = {uri: end for uri, end in self._pauses.items() if end > now}
            asked = {uri: each for uri, each in servers.items() if uri not in self._pauses}
            self._pauses.update(dict.fromkeys(asked, math.inf))
        threads = [
            threading.Thread(target=self._ask, args=each, name="service types", daemon=True)
            for each in asked.items()
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(max(0.0, now + _PATIENCE - time.monotonic()))

    @property
    def types(self) -> Dict[str, service_types.ServiceType]:
        """The types of the services by name, as far as they are known."""
        with self._lock:
            found = sorted(self._services.items())
        return {name: service.type for (name, _), service in found if service.type is not None}

    def call(self, name: str, kind: service_types.ServiceType, request: Any) -> Any:
        """Calls a service, waits for its response and returns it.

        Raises:
            BridgeError: the server is gone, does not answer, or reports an error.
        """
        with self._lock:
            uris = [each.uri for (other, _), each in self._services.items() if other == name]
        md5sum = getattr(kind.ros_class, "_md5sum", "*")
        try:
            data = serialized(request)
            connection, header = _open(uris[0] if uris else "", service=name, md5sum=md5sum)
            with connection:
                if "error" in header:
                    raise ConnectionError(header["error"])
                connection.sendall(LENGTH.pack(len(data)) + data)
                is_answered = _read(connection, 1) != b"\0"
                answer = _read_block(connection)
            if not is_answered:
                raise BridgeError(f"the service {name} fails: {answer.decode(errors='replace')}")
            return deserialized(kind.response, answer)
        except (*_NO_ANSWER, *WRONG_VALUE, MessageError) as error:
            raise BridgeError(f"the service {name} cannot be called: {error}") from None

    def _ask(self, uri: str, registrations: List[Registration]) -> None:
        has_answered = False
        try:
            for registration in registrations:
                service = Service(uri, _type_of(registration[0], uri))
                with self._lock:
                    self._services[registration] = service
            has_answered = True
        except _NO_ANSWER:
            pass  # it is stopped or gone
        finally:
            with self._lock:
                self._pauses[uri] = time.monotonic() + (0.0 if has_answered else _RETRY_PERIOD)


def _type_of(name: str, uri: str) -> Optional[service_types.ServiceType]:
    """The type that a server gives a service; None if it is not known here.

    Raises:
        _NO_ANSWER: one of these.
    """
    connection, header = _open(uri, service=name, md5sum="*", probe="1")
    connection.close()
    try:
        return service_types.get(header["type"])
    except (KeyError, MessageError):
        return None


def _open(uri: str, **fields: str) -> Tuple[socket.socket, Dict[str, str]]:
    """A connection to a server, and the header with which it answers.

    Raises:
        _NO_ANSWER: one of these.
    """
    end = time.monotonic() + _ANSWER_LIMIT
    place = urlparse(uri)
    connection = socket.create_connection((place.hostname, place.port or 0), _ANSWER_LIMIT)
    try:
        connection.sendall(encode_ros_handshake_header({"callerid": rospy.get_name(), **fields}))
        connection.settimeout(_LOOK_PERIOD)
        block = _read_block(connection, end, _LARGEST_HEADER)
        return connection, decode_ros_handshake_header(LENGTH.pack(len(block)) + block)
    except BaseException:
        connection.close()
        raise


def _read_block(connection: socket.socket, end: float = math.inf, most: float = math.inf) -> bytes:
    """Reads bytes that come after their number, until a time of `time.monotonic`."""
    (length,) = LENGTH.unpack(_read(connection, LENGTH.size, end))
    if length > most:
        raise ConnectionError(f"expected at most {most} bytes, found {length}")
    return _read(connection, length, end)


def _read(connection: socket.socket, size: int, end: float = math.inf) -> bytes:
    data = bytearray()
    while len(data) < size:
        if time.monotonic() > end or rospy.is_shutdown() or client_is_gone():
            raise TimeoutError("it does not answer")
        try:
            more = connection.recv(min(size - len(data), 1 << 16))
        except socket.timeout:
            continue
        if not more:
            raise ConnectionError("it has closed the connection")
        data += more
    return bytes(data)

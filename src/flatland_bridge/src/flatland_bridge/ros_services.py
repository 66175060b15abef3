"""The types of a ROS master's services, which only their servers know."""

import threading
import time
from typing import Dict, List, Optional, Tuple

import rosgraph.network
import rosservice

from flatland_server.exceptions import MessageError
from flatland_server.messages import service_types
from flatland_server.ros.rospy_patches.master_calls import Master

_RETRY_PERIOD = 5.0
"""Real time after which a server that has not answered is asked again [s]."""
_PATIENCE = 1.0
"""Real time that `follow` waits for servers, most of which answer within milliseconds [s]."""
_NO_ANSWER = (OSError, rosservice.ROSServiceException, rosgraph.network.ROSHandshakeException)

Registration = Tuple[str, str]
"""The name of a service, and the URI of its node, which changes when the node is restarted."""


class ServiceTypes:
    """Asks each server on a thread of its own: one that is stopped or gone delays no other."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._types: Dict[Registration, Optional[service_types.ServiceType]] = {}
        self._pauses: Dict[str, float] = {}  # until when a server is not asked, by its URI

    def follow(self, registrations: List[Registration], master: Master) -> None:
        """Asks for the types of services that are new, or whose servers did not answer.

        Args:
            registrations: all that there are.
            master: is asked for their URIs.

        Raises:
            NO_ANSWER: one of these, by the master.
        """
        with self._lock:
            known = set(registrations)
            self._types = {each: kind for each, kind in self._types.items() if each in known}
            new = {each[0]: each for each in registrations if each not in self._types}
        servers: Dict[str, List[Registration]] = {}
        for name, uri in (master.uris(new, "lookupService") if new else {}).items():
            servers.setdefault(uri, []).append(new[name])
        now = time.monotonic()
        with self._lock:
            self._pauses = {uri: end for uri, end in self._pauses.items() if end > now}
            asked = {uri: each for uri, each in servers.items() if uri not in self._pauses}
            self._pauses.update(dict.fromkeys(asked, float("inf")))
        threads = [
            threading.Thread(target=self._ask, args=each, name="service types", daemon=True)
            for each in asked.items()
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(max(0.0, now + _PATIENCE - time.monotonic()))

    @property
    def known(self) -> Dict[str, service_types.ServiceType]:
        """The services whose types are known, by name."""
        with self._lock:
            return {name: kind for (name, _), kind in sorted(self._types.items()) if kind}

    def _ask(self, uri: str, registrations: List[Registration]) -> None:
        has_answered = False
        try:
            for registration in registrations:
                kind = _type_of(registration[0], uri)
                with self._lock:
                    self._types[registration] = kind
            has_answered = True
        except _NO_ANSWER:
            pass  # it is stopped or gone, or not that of this registration any more
        finally:
            with self._lock:
                self._pauses[uri] = time.monotonic() + (0.0 if has_answered else _RETRY_PERIOD)


def _type_of(name: str, uri: str) -> Optional[service_types.ServiceType]:
    """The type that a server gives a service; None if it is not known here.

    Raises:
        _NO_ANSWER: one of these, within seconds.
    """
    header = rosservice.get_service_headers(name, uri)
    try:
        return service_types.get(header["type"])
    except (KeyError, MessageError):
        return None

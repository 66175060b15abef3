"""Registers many topics and services with the master in one call.

rospy makes a call for each topic, waits for its answer and wakes a thread that checks all topics
of the node: with a thousand robots, that takes longer than the rest of loading the world.
"""

import xmlrpc.client
from contextlib import contextmanager
from typing import Any, Dict, Iterator, List, Tuple

import rospy
from rospy.impl.registration import (
    Registration,
    RegistrationListener,
    get_registration_listeners,
)

from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

_MODULE = "rospy.impl.registration"
_ADDED = ("self", "resolved_name", "data_type_or_uri", "reg_type")

REQUIREMENTS = (
    Requirement(f"{_MODULE}:get_registration_listeners", ()),
    Requirement(f"{_MODULE}:RegistrationListeners.__init__", uses=("listeners", "lock")),
    Requirement(f"{_MODULE}:RegistrationListener.reg_added", _ADDED),
    Requirement(f"{_MODULE}:RegistrationListener.reg_removed", _ADDED),
    Requirement(f"{_MODULE}:RegManager.__init__", uses=("uri", "master_uri")),
    Requirement(f"{_MODULE}:RegManager.publisher_update", ("self", "resolved_name", "uris")),
    Requirement(f"{_MODULE}:Registration.PUB"),
    Requirement(f"{_MODULE}:Registration.SUB"),
    Requirement(f"{_MODULE}:Registration.SRV"),
    Requirement("rospy.core:xmlrpcapi"),
)

_METHODS = {
    Registration.PUB: "registerPublisher",
    Registration.SUB: "registerSubscriber",
    Registration.SRV: "registerService",
}


def install() -> Dict[str, Any]:
    """Checks the requirements. Returns the call that this replaces."""
    check_all(REQUIREMENTS)
    return {"batch_registration": batch_registration}


@contextmanager
def batch_registration() -> Iterator[None]:
    """Registers what is opened within this context at its end, in one call to the master."""
    listeners = get_registration_listeners()
    with listeners.lock:
        original = listeners.listeners
        collector = _Collector(original)
        listeners.listeners = [collector]
    try:
        yield
    finally:
        with listeners.lock:
            listeners.listeners = original
    for manager in original:
        _register(manager, collector.entries)


class _Collector(RegistrationListener):  # type: ignore[misc]
    """Collects registrations in place of rospy's own listeners.

    Args:
        original: rospy's listeners, which register with the master.
    """

    def __init__(self, original: List[Any]) -> None:
        self.entries: Dict[Tuple[str, str], str] = {}
        """The type of a topic, or the URI of a service, by kind of registration and name."""
        self._original = original

    def reg_added(self, name: str, detail: str, kind: str) -> None:
        self.entries[kind, name] = detail

    def reg_removed(self, name: str, detail: str, kind: str) -> None:
        if self.entries.pop((kind, name), None) is None:
            for listener in self._original:
                listener.reg_removed(name, detail, kind)


def _register(manager: Any, entries: Dict[Tuple[str, str], str]) -> None:
    """Registers the entries with the master.

    Args:
        manager: rospy's RegManager, which would do so one by one.
        entries: as collected.
    """
    calls = xmlrpc.client.MultiCall(rospy.core.xmlrpcapi(manager.master_uri))
    for (kind, name), detail in entries.items():
        getattr(calls, _METHODS[kind])(rospy.get_caller_id(), name, detail, manager.uri)
    try:
        answers = list(calls())
    except (OSError, xmlrpc.client.Error):
        answers = [(0, "", [])] * len(entries)
    for ((kind, name), detail), (code, _, publishers) in zip(entries.items(), answers):
        if code != 1:
            manager.reg_added(name, detail, kind)  # logs the error, or repeats until it succeeds
        elif kind == Registration.SUB and publishers:
            manager.publisher_update(name, publishers)

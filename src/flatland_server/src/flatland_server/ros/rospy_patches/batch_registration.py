"""Telling the master of many topics at once.

rospy makes a call for each topic and waits for its answer, and wakes a thread that looks at all
topics there are: with a thousand robots, that takes longer than all else of loading the world.
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

_METHODS = {
    Registration.PUB: "registerPublisher",
    Registration.SUB: "registerSubscriber",
    Registration.SRV: "registerService",
}


@contextmanager
def batch_registration() -> Iterator[None]:
    """What is opened within it, the master is told of at its end, in one call."""
    listeners = get_registration_listeners()
    with listeners.lock:
        usual = listeners.listeners
        gathered = _Gathered(usual)
        listeners.listeners = [gathered]
    try:
        yield
    finally:
        with listeners.lock:
            listeners.listeners = usual
    for manager in usual:
        _register(manager, gathered.entries)


class _Gathered(RegistrationListener):  # type: ignore[misc]
    """Stands in for those whom rospy tells of new topics and services, who tell the master.

    Args:
        usual: they.
    """

    def __init__(self, usual: List[Any]) -> None:
        self.entries: Dict[Tuple[str, str], str] = {}
        """By what it is, a publisher for instance, and by name: its type, or a service's URI."""
        self._usual = usual

    def reg_added(self, name: str, detail: str, kind: str) -> None:
        self.entries[kind, name] = detail

    def reg_removed(self, name: str, detail: str, kind: str) -> None:
        if self.entries.pop((kind, name), None) is None:
            for listener in self._usual:
                listener.reg_removed(name, detail, kind)


def _register(manager: Any, entries: Dict[Tuple[str, str], str]) -> None:
    """Tells the master; `manager` is rospy's RegManager, which would do it one by one."""
    calls = xmlrpc.client.MultiCall(rospy.core.xmlrpcapi(manager.master_uri))
    for (kind, name), detail in entries.items():
        getattr(calls, _METHODS[kind])(rospy.get_caller_id(), name, detail, manager.uri)
    try:
        answers = list(calls())
    except (OSError, xmlrpc.client.Error):
        answers = [(0, "", [])] * len(entries)
    for ((kind, name), detail), (code, _, publishers) in zip(entries.items(), answers):
        if code != 1:
            manager.reg_added(name, detail, kind)  # it complains, or tries until it succeeds
        elif kind == Registration.SUB and publishers:
            manager.publisher_update(name, publishers)

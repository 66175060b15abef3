"""Calls to the ROS master, each with a limited time."""

import http.client
import xmlrpc.client
from typing import Any, Dict, Iterable, List, NamedTuple, Tuple
from xml.parsers.expat import ExpatError

import rospy
from rospy.impl.registration import Registration

_REGISTER = {
    Registration.PUB: "registerPublisher",
    Registration.SUB: "registerSubscriber",
    Registration.SRV: "registerService",
}
_UNREGISTER = {
    Registration.PUB: "unregisterPublisher",
    Registration.SUB: "unregisterSubscriber",
    Registration.SRV: "unregisterService",
}

ANSWER_LIMIT = 3.0
"""Real time that the master has to answer [s]."""

NO_ANSWER = (OSError, http.client.HTTPException, xmlrpc.client.Error, ExpatError)
"""The exceptions of a call without an answer, or with a part of one."""

Key = Tuple[str, str]
"""The kind of a registration, and the name of the topic or service."""


class Change(NamedTuple):
    """A registration to be made or to be ended.

    Attributes:
        is_open: whether it is to be made.
        kind: the registration's kind.
        name: of the topic or service.
        detail: a topic's type, or a service's URI.
    """

    is_open: bool
    kind: str
    name: str
    detail: str


class _LimitedTransport(xmlrpc.client.Transport):
    """HTTP with a limit for each answer."""

    def make_connection(self, host: Any) -> Any:
        connection = super().make_connection(host)
        connection.timeout = ANSWER_LIMIT
        return connection


class Master:
    """The calls to the master, all over one connection. Not for several threads."""

    def __init__(self, uri: str) -> None:
        self.uri = uri
        self._proxy = xmlrpc.client.ServerProxy(uri, transport=_LimitedTransport())

    def apply(self, changes: List[Change], node_uri: str) -> List[Any]:
        """Makes all changes in one call. Returns the answer to each: code, status, value.

        Raises:
            NO_ANSWER: one of these.
        """
        calls = xmlrpc.client.MultiCall(self._proxy)
        for change in changes:
            method = (_REGISTER if change.is_open else _UNREGISTER)[change.kind]
            call = getattr(calls, method)
            node = rospy.get_caller_id()
            if change.is_open:
                call(node, change.name, change.detail, node_uri)
            elif change.kind == Registration.SRV:
                call(node, change.name, change.detail)
            else:
                call(node, change.name, node_uri)
        return list(calls())

    def ask(self, method: str, *arguments: Any, default: Any = None) -> Any:
        """Calls a method of the master's API.

        Args:
            method: such as "getParam".
            arguments: without the caller's name.
            default: returned if the master refuses.

        Raises:
            NO_ANSWER: one of these.
        """
        answer: Any = getattr(self._proxy, method)(rospy.get_caller_id(), *arguments)
        return answer[2] if answer[0] == 1 else default

    def publishers(self) -> List[Any]:
        """The topics that are published: pairs of a name and its nodes' names.

        Raises:
            NO_ANSWER: one of these.
        """
        return list(self.ask("getSystemState", default=[[]])[0])

    def graph(self) -> Tuple[List[Any], List[Any], List[Any], Dict[str, str]]:
        """Published topics, subscribed topics and services with their nodes; types of topics.

        Raises:
            NO_ANSWER: one of these.
        """
        calls = xmlrpc.client.MultiCall(self._proxy)
        calls.getSystemState(rospy.get_caller_id())
        calls.getTopicTypes(rospy.get_caller_id())
        (_, _, (published, subscribed, services)), (_, _, types) = calls()
        return published, subscribed, services, dict(types)

    def uris(self, names: Iterable[str], method: str = "lookupNode") -> Dict[str, str]:
        """The URIs of nodes, or of services by the method lookupService, that the master knows.

        Raises:
            NO_ANSWER: one of these.
        """
        calls = xmlrpc.client.MultiCall(self._proxy)
        names = list(names)
        for name in names:
            getattr(calls, method)(rospy.get_caller_id(), name)
        return {name: uri for name, (code, _, uri) in zip(names, calls()) if code == 1}

    def has_service(self, name: str, uri: str) -> bool:
        """True if the master knows this service.

        Raises:
            NO_ANSWER: one of these.
        """
        return bool(self.ask("lookupService", name) == uri)

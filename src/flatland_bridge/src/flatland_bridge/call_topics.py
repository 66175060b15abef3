"""Services as topics, for transports without services."""

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, Dict, List, Optional

import orjson

from flatland_bridge.budget import Budget
from flatland_bridge.client_calls import reason_of
from flatland_bridge.graph import BridgeError, Graph, Receive, Topics
from flatland_bridge.plain_form import from_plain, to_plain
from flatland_bridge.sample import Sample
from flatland_server.exceptions import shortened
from flatland_server.messages.message_types import get
from flatland_server.messages.service_types import ServiceType

String = get("std_msgs/String")

CALLS, RESPONSES = "/flatland_server/call_service", "/flatland_server/service_response"

_WORKERS = 4
_MOST_CALLS = 50
"""Calls that may go on at the same time."""


class CallTopics(Graph):
    """A graph with two topics more, of std_msgs/String with JSON as in the rosbridge protocol.

    `/flatland_server/call_service` takes `{"service": "/step", "args": {"steps": 20}, "id": 1}`;
    `/flatland_server/service_response` has the response: `{"service": "/step", "values": {...},
    "result": true, "id": 1}`.

    Args:
        graph: has all else.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self.parameters = graph.parameters
        self._pool = ThreadPoolExecutor(_WORKERS, "call")
        self._free = threading.Semaphore(_MOST_CALLS)
        self._receivers: List[Receive] = []

    @property
    def topics(self) -> Topics:
        published, subscribed, latched = self._graph.topics
        kind = String._type
        return Topics({**published, RESPONSES: kind}, {**subscribed, CALLS: kind}, latched)

    @property
    def services(self) -> Dict[str, ServiceType]:
        return self._graph.services

    @property
    def nanoseconds(self) -> int:
        return self._graph.nanoseconds

    def subscribe(
        self, topic: str, receive: Receive, client: Optional[Budget] = None
    ) -> Callable[[], None]:
        if topic != RESPONSES:
            return self._graph.subscribe(topic, receive, client)
        self._receivers = [*self._receivers, receive]

        def end() -> None:
            self._receivers = [each for each in self._receivers if each is not receive]

        return end

    def publish(self, topic: str, message: Any, client: Optional[Budget] = None) -> None:
        if topic != CALLS:
            self._graph.publish(topic, message, client)
        elif not self._free.acquire(blocking=False):
            raise BridgeError(f"{_MOST_CALLS} calls go on already")
        else:
            done = self._pool.submit(self._respond, message.data)
            done.add_done_callback(lambda _: self._free.release())

    def call(self, service: str, request: Any) -> Any:
        return self._graph.call(service, request)

    def close(self) -> None:
        """Begins no further call."""
        self._pool.shutdown(wait=False)

    def _respond(self, text: str) -> None:
        """Calls a service, and publishes its response; on a thread of the pool."""
        response: Dict[str, Any] = {"service": None, "values": None, "result": False}
        try:
            call = orjson.loads(text)
            if not isinstance(call, dict) or not isinstance(call.get("service"), str):
                raise BridgeError(f'expected {{"service": "...", ...}}, found {shortened(text)}')
            response.update((key, call[key]) for key in ("service", "id") if key in call)
            kind = self._graph.service_type(call["service"])
            request = from_plain(kind.request, call.get("args") or {})
            response["values"] = to_plain(self._graph.call(call["service"], request))
            response["result"] = True
        except orjson.JSONDecodeError as error:
            response["values"] = f"expected JSON: {shortened(str(error))}"
        except Exception as error:  # the caller would wait for ever
            response["values"] = reason_of(error, str(response["service"]))
        data = orjson.dumps(response, option=orjson.OPT_SERIALIZE_NUMPY).decode()
        sample = Sample(RESPONSES, self.nanoseconds, String, String(data))
        for receive in self._receivers:
            receive(sample)

"""One client of the rosbridge protocol, version 2.

https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md
"""

import asyncio
import itertools
from concurrent.futures import Executor
from typing import Any, Callable, Dict, Optional, Set, Tuple

from flatland_bridge.client_messages import Message, field, id_of, message_of, name_of, whole
from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.outbox import Data, Outbox, Send, Stream
from flatland_bridge.plain_form import from_plain, to_plain
from flatland_bridge.rosapi import RosApi
from flatland_bridge.rosbridge_form import COMPRESSIONS, encoded, publisher
from flatland_server.exceptions import FlatlandError, MessageError, shortened, suggestion
from flatland_server.messages.message_types import get

_LEVELS = ("none", "error", "warning", "info")
_MOST_TOPICS = 500
"""Topics that a client may subscribe to."""
_MOST_CALLS = 50
"""Calls of services that may go on for a client at the same time."""
_MOST_FRAGMENTS = 1000
"""Fragments of messages that a client may have sent incompletely."""
_LARGEST = 16_000_000
"""Characters of all of them."""


class Providers:
    """Services that clients offer to other clients."""

    def __init__(self) -> None:
        self.sessions: Dict[str, RosbridgeSession] = {}
        """The client that offers a service, by the service's name."""
        self.calls: Dict[str, Tuple[RosbridgeSession, Message]] = {}
        """Callers that wait, and what they have called, by the id of the call."""
        self.numbers = itertools.count(1)


class RosbridgeSession:
    """Obeys a client, which is told what is wrong with its messages, and stays connected.

    Args:
        graph: the topics and services.
        pool: calls services, which takes time.
        providers: services of other clients.
    """

    def __init__(self, graph: Graph, pool: Executor, providers: Providers) -> None:
        self._graph = graph
        self._outbox = Outbox()
        self._pool = pool
        self._providers = providers
        self._rosapi = RosApi(graph)
        self._level = "error"
        self._subscriptions: Dict[str, Callable[[], None]] = {}  # ends each, by topic
        self._ids: Dict[str, Set[Any]] = {}  # under which a topic was subscribed to
        self._advertised: Dict[str, str] = {}  # types by topic
        self._calls: Set[asyncio.Task[None]] = set()
        self._fragments: Dict[str, Dict[int, str]] = {}
        self._operations: Dict[Any, Callable[[Message], None]] = {
            "advertise": self._advertise,
            "advertise_service": self._advertise_service,
            "auth": lambda message: None,  # the token is in the URL
            "call_service": self._call_service,
            "fragment": self._fragment,
            "publish": self._publish,
            "service_response": self._service_response,
            "set_level": self._set_level,
            "status": lambda message: None,
            "subscribe": self._subscribe,
            "unadvertise": self._unadvertise,
            "unadvertise_service": self._unadvertise_service,
            "unsubscribe": self._unsubscribe,
        }

    def handle(self, data: Data) -> None:
        """Obeys a message of the client.

        Args:
            data: JSON text, or CBOR bytes.
        """
        message: Message = {}
        try:
            message = message_of(data)
            operation = field(message, "op", str)
            if operation not in self._operations:
                hint = suggestion(operation, self._operations)
                raise BridgeError(f'there is no operation "{shortened(operation)}"{hint}')
            self._operations[operation](message)
        except FlatlandError as error:
            self._status("error", str(error), message)

    async def run(self, send: Send) -> None:
        """Sends messages for ever."""
        await self._outbox.send_all(send)

    def close(self) -> None:
        """Ends all that the client has begun."""
        for end in self._subscriptions.values():
            end()
        for task in self._calls:
            task.cancel()
        providers = self._providers
        for name in [name for name, each in providers.sessions.items() if each is self]:
            del providers.sessions[name]
        for number, (caller, message) in list(providers.calls.items()):
            if caller is self or number.startswith(f"{id(self)}:"):
                del providers.calls[number]
                if caller is not self:
                    caller._respond(message, "the client that offers it is gone", False)

    # Topics

    def _subscribe(self, message: Message) -> None:
        topic, kind = name_of(message, "topic"), message.get("type")
        known = self._graph.topics.types.get(topic)
        if kind is not None and known not in (None, _ros1_name(kind)):
            raise BridgeError(
                f'the topic "{topic}" has the type {known}, not {shortened(str(kind))}'
            )
        if topic not in self._subscriptions and len(self._subscriptions) >= _MOST_TOPICS:
            raise BridgeError(f"a client may subscribe to {_MOST_TOPICS} topics")
        compression = message.get("compression", "none")
        if not isinstance(compression, str) or compression not in COMPRESSIONS:
            names = ", ".join(COMPRESSIONS)
            self._status("warning", f"compression: expected {names}; it is none", message)
            compression = "none"
        size = whole(message, "fragment_size", 0)
        stream = Stream(
            publisher(compression, size),
            self._outbox.wake,
            whole(message, "throttle_rate", 0) / 1000.0,
            whole(message, "queue_length", 0),
        )
        end = self._graph.subscribe(topic, stream.receive)
        if topic in self._subscriptions:  # once more: the last one says how
            self._subscriptions[topic]()
        self._outbox.streams[topic] = stream
        self._subscriptions[topic] = end
        self._ids.setdefault(topic, set()).add(str(message.get("id")))

    def _unsubscribe(self, message: Message) -> None:
        topic = name_of(message, "topic")
        ids = self._ids.get(topic, set())
        ids.discard(str(message.get("id")))
        if message.get("id") is None or not ids:
            self._ids.pop(topic, None)
            self._outbox.streams.pop(topic, None)
            end = self._subscriptions.pop(topic, None)
            if end is not None:
                end()

    def _advertise(self, message: Message) -> None:
        topic, kind = name_of(message, "topic"), _ros1_name(message.get("type"))
        message_type = get(kind)
        known = self._graph.topics.types.get(topic)
        if known not in (None, kind):
            raise BridgeError(f'the topic "{topic}" has the type {known}, not {kind}')
        if topic not in self._advertised and len(self._advertised) >= _MOST_TOPICS:
            raise BridgeError(f"a client may advertise {_MOST_TOPICS} topics")
        self._advertised[topic] = kind
        self._graph.advertise(topic, message_type)

    def _unadvertise(self, message: Message) -> None:
        self._advertised.pop(name_of(message, "topic"), None)

    def _publish(self, message: Message) -> None:
        topic = name_of(message, "topic")
        types = self._graph.topics.types
        kind = self._advertised.get(topic) or types.get(topic)
        if kind is None:
            hint = suggestion(topic, types)
            raise BridgeError(f'there is no topic "{topic}"{hint}; advertise it with its type')
        content = from_plain(get(kind), message.get("msg", {}))
        if isinstance(message.get("msg"), dict):
            self._stamp(content, message["msg"])
        self._graph.publish(topic, content)

    def _stamp(self, content: Any, given: Message) -> None:
        """Sets a stamp that the client has left out to the present time."""
        if not content._has_header:
            return
        header = given.get("header")
        if not (isinstance(header, dict) and "stamp" in header):
            seconds, nanoseconds = divmod(self._graph.nanoseconds, 1_000_000_000)
            content.header.stamp = type(content.header.stamp)(seconds, nanoseconds)

    # Services

    def _call_service(self, message: Message) -> None:
        name = name_of(message, "service")
        whole(message, "fragment_size", 0)  # of the answer
        provider = self._providers.sessions.get(name)
        if provider is not None:
            number = f"{id(provider)}:{next(self._providers.numbers)}"
            self._providers.calls[number] = (self, message)
            call = {"op": "call_service", "id": number, "service": name}
            provider._send({**call, "args": message.get("args", {})})
            return
        if len(self._calls) >= _MOST_CALLS:
            self._respond(message, f"a client may make {_MOST_CALLS} calls at a time", False)
            return
        task = asyncio.get_running_loop().create_task(self._call(name, message))
        self._calls.add(task)
        task.add_done_callback(self._calls.discard)

    async def _call(self, name: str, message: Message) -> None:
        loop = asyncio.get_running_loop()
        try:
            values = await loop.run_in_executor(self._pool, self._answer, name, message)
        except FlatlandError as error:
            self._respond(message, str(error), False)
        else:
            self._respond(message, values, True)

    def _answer(self, name: str, message: Message) -> Any:
        """The values of a service's response; on a thread of the pool."""
        arguments = message.get("args")
        arguments = {} if arguments is None else arguments
        if name in self._rosapi.services:
            return self._rosapi.services[name](arguments if isinstance(arguments, dict) else {})
        kind = self._graph.service_type(name)
        response = self._graph.call(name, from_plain(kind.request, arguments))
        return to_plain(response, cbor=message.get("compression") == "cbor")

    def _respond(self, call: Message, values: Any, succeeded: bool) -> None:
        response = {"op": "service_response", "service": call.get("service"), **id_of(call)}
        try:
            self._send({**response, "values": values, "result": succeeded}, call)
        except BridgeError as error:
            self._send({**response, "values": str(error), "result": False}, call)

    def _advertise_service(self, message: Message) -> None:
        name = name_of(message, "service")
        if name in self._graph.services or name in self._rosapi.services:
            raise BridgeError(f'there is a service "{name}" already')
        if self._providers.sessions.setdefault(name, self) is not self:
            raise BridgeError(f'another client offers the service "{name}"')

    def _unadvertise_service(self, message: Message) -> None:
        name = name_of(message, "service")
        if self._providers.sessions.get(name) is self:
            del self._providers.sessions[name]

    def _service_response(self, message: Message) -> None:
        caller, call = self._providers.calls.pop(str(message.get("id")), (None, {}))
        if caller is not None:
            caller._respond(call, message.get("values"), message.get("result") is True)

    # Fragments, and messages about messages

    def _fragment(self, message: Message) -> None:
        number, total = whole(message, "num"), whole(message, "total")
        data, key = field(message, "data", str), str(message.get("id"))
        if number >= total:
            raise BridgeError(f"num: expected less than total ({total}), found {number}")
        parts = self._fragments.setdefault(key, {})
        parts[number] = data
        if len(parts) == total:
            del self._fragments[key]
            self.handle("".join(parts[index] for index in range(total)))
            return
        texts = [text for each in self._fragments.values() for text in each.values()]
        if len(texts) > _MOST_FRAGMENTS or sum(map(len, texts)) > _LARGEST:
            self._fragments.clear()
            raise BridgeError("there are too many fragments of incomplete messages")

    def _set_level(self, message: Message) -> None:
        level = field(message, "level", str)
        if level not in _LEVELS:
            raise BridgeError(
                f"level: expected {', '.join(_LEVELS)}, found {shortened(repr(level))}"
            )
        self._level = level

    def _status(self, level: str, text: str, about: Message) -> None:
        if _LEVELS.index(level) <= _LEVELS.index(self._level):
            status = {"op": "status", "level": level, "msg": text}
            self._send({**status, **id_of(about)})

    def _send(self, message: Message, call: Optional[Message] = None) -> None:
        call = call or {}
        size = whole(call, "fragment_size", 0)
        for data in encoded(message, str(call.get("compression")), size):
            self._outbox.reply(data)


def _ros1_name(kind: Any) -> str:
    """The name of a type, which clients may write as in ROS 2: "std_msgs/msg/String"."""
    if not isinstance(kind, str):
        raise MessageError(f"expected the name of a type, found {shortened(repr(kind))}")
    return kind.replace("/msg/", "/")

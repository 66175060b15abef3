"""One client of the rosbridge protocol, version 2.

https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md
"""

import itertools
import sys
from concurrent.futures import Executor
from functools import partial
from typing import Any, Callable, Collection, Dict, Iterable, List, NamedTuple, Tuple

from flatland_bridge.budget import ENTRY, Budget
from flatland_bridge.client_calls import MOST_CALLS, ClientCalls
from flatland_bridge.client_messages import Message, field, id_of, message_of, name_of, whole
from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.outbox import MOST_MESSAGES, Data, Encode, Outbox, Send, Stream
from flatland_bridge.plain_form import from_plain, to_plain
from flatland_bridge.rosapi import RosApi
from flatland_bridge.rosbridge_form import COMPRESSIONS, encoded, publisher
from flatland_server.exceptions import FlatlandError, MessageError, shortened, suggestion
from flatland_server.messages import get

_LEVELS = ("none", "error", "warning", "info")
_MOST_TOPICS = 500
"""Topics that a client may subscribe to, and times that it may subscribe to each."""
_LARGEST = 64_000_000
"""Bytes that a message in fragments takes once it is decoded, at most."""
_OF_ANSWERS = ("id", "service", "compression", "fragment_size")
"""Fields of a call that its answer depends on."""
_DECODED = {"{": 64, "[": 56, ",": 8, ".": 24}
"""Bytes of a decoded object, array, reference and fraction, by a character that each has."""


class _Wish(NamedTuple):
    """A part of a client, and its wish for the messages of a topic.

    Attributes:
        compression: one of `COMPRESSIONS`.
        fragment_size: as for `encoded`; 0 is any.
        throttle: shortest time between two messages [s].
        length: how many messages wait; 0 drops what comes early.
        size: its bytes in the client's budget.
    """

    compression: str
    fragment_size: int
    throttle: float
    length: int
    size: int


class _Subscription(NamedTuple):
    """A client's subscription to a topic: its messages, its end, and all wishes by their ids."""

    stream: Stream
    end: Callable[[], None]
    wishes: Dict[str, _Wish]


class Offered(NamedTuple):
    """A call of a service that another client offers.

    Attributes:
        caller: waits for the response.
        message: of the call, without its arguments.
        provider: offers the service.
        size: its bytes in the caller's budget.
    """

    caller: "RosbridgeSession"
    message: Message
    provider: "RosbridgeSession"
    size: int


class Providers:
    """Services that clients offer to other clients."""

    def __init__(self) -> None:
        self.sessions: Dict[str, RosbridgeSession] = {}
        """The client that offers a service, by the service's name."""
        self.calls: Dict[str, Offered] = {}
        """Calls that are not answered yet, by their ids."""
        self.numbers = itertools.count(1)

    def end_call(self, number: str) -> None:
        """Forgets a call."""
        call = self.calls.pop(number)
        call.caller.budget.hold(-call.size)


class RosbridgeSession:
    """Obeys a client, which is told what is wrong with its messages, and stays connected.

    Args:
        graph: the topics and services.
        pool: runs the calls of services.
        providers: services of other clients.
        budget: counts all that is kept for the client.
    """

    def __init__(self, graph: Graph, pool: Executor, providers: Providers, budget: Budget) -> None:
        self.budget = budget
        self._graph = graph
        self._outbox = Outbox(budget, pool)
        self._calls = ClientCalls(pool, budget, self._outbox)
        self._providers = providers
        self._rosapi = RosApi(graph)
        self._level = "error"
        self._subscriptions: Dict[str, _Subscription] = {}  # by topic
        self._advertised: Dict[str, Tuple[str, Callable[[], None]]] = {}  # type, end
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
        self._data = data
        try:
            message = message_of(data)
            operation = field(message, "op", str)
            if operation not in self._operations:
                hint = suggestion(operation, self._operations)
                raise BridgeError(f'there is no operation "{shortened(operation)}"{hint}')
            self._operations[operation](message)
        except FlatlandError as error:
            self._status("error", str(error), message)
        finally:
            self._data = ""

    async def run(self, send: Send) -> None:
        """Sends messages for ever."""
        await self._outbox.send_all(send)

    def status(self, text: str) -> Data:
        """A message that tells the client of an error."""
        (data,) = encoded({"op": "status", "level": "error", "msg": text}, "none", 0)
        return data

    def close(self) -> None:
        """Ends all that the client has begun."""
        for subscription in self._subscriptions.values():
            subscription.end()
        for _, end in self._advertised.values():
            end()
        providers = self._providers
        for name in [name for name, each in providers.sessions.items() if each is self]:
            self._withdraw(name)
        for number, call in list(providers.calls.items()):
            if self in (call.caller, call.provider):
                providers.end_call(number)
                if call.caller is not self:
                    call.caller._respond(call.message, "the client that offers it is gone", False)
        self._outbox.close_all()
        self._calls.close()

    # Topics

    def _subscribe(self, message: Message) -> None:
        topic, kind = name_of(message, "topic"), message.get("type")
        known = self._graph.topics.types.get(topic)
        if kind is not None and known not in (None, _ros1_name(kind)):
            raise BridgeError(
                f'the topic "{topic}" has the type {known}, not {shortened(str(kind))}'
            )
        found, name = self._subscriptions.get(topic), str(message.get("id"))
        if found is None and len(self._subscriptions) >= _MOST_TOPICS:
            raise BridgeError(f"a client may subscribe to {_MOST_TOPICS} topics")
        wishes = {} if found is None else found.wishes
        if name not in wishes and len(wishes) >= _MOST_TOPICS:
            raise BridgeError(f"a client may subscribe to a topic {_MOST_TOPICS} times")
        wish = self._wish(message, wishes[name].size if name in wishes else _size(topic, name))
        how = _agreed({**wishes, name: wish}.values())
        if found is None:
            report = partial(self._status, "error", about={})
            stream = Stream(how[0], self._outbox.wake, self.budget, report, *how[1:])
        else:
            stream = found.stream
        end = self._graph.subscribe(topic, stream.receive, self.budget)
        if found is None:
            self._outbox.open(topic, stream)
        else:
            stream.change(*how)
        self._subscriptions[topic] = _Subscription(stream, end, wishes)
        if name not in wishes:
            self.budget.hold(wish.size)
        wishes[name] = wish

    def _wish(self, message: Message, size: int) -> _Wish:
        compression = message.get("compression", "none")
        if not isinstance(compression, str) or compression not in COMPRESSIONS:
            names = ", ".join(COMPRESSIONS)
            self._status("warning", f"compression: expected {names}; it is none", message)
            compression = "none"
        throttle = whole(message, "throttle_rate", 0) / 1000.0
        length = whole(message, "queue_length", 0) or (0 if throttle else MOST_MESSAGES)
        return _Wish(compression, whole(message, "fragment_size", 0), throttle, length, size)

    def _unsubscribe(self, message: Message) -> None:
        topic = name_of(message, "topic")
        if topic not in self._subscriptions:
            return
        stream, end, wishes = self._subscriptions[topic]
        for name in list(wishes) if message.get("id") is None else [str(message["id"])]:
            if name in wishes:
                self.budget.hold(-wishes.pop(name).size)
        if wishes:
            stream.change(*_agreed(wishes.values()))
        else:
            del self._subscriptions[topic]
            self._outbox.close(topic)
            end()

    def _advertise(self, message: Message) -> None:
        topic, kind = name_of(message, "topic"), _ros1_name(message.get("type"))
        message_type = get(kind)
        known = self._graph.topics.types.get(topic)
        if known not in (None, kind):
            raise BridgeError(f'the topic "{topic}" has the type {known}, not {kind}')
        if topic not in self._advertised and len(self._advertised) >= _MOST_TOPICS:
            raise BridgeError(f"a client may advertise {_MOST_TOPICS} topics")
        self._unadvertise(message)
        self._advertised[topic] = kind, self._graph.advertise(topic, message_type)
        self.budget.hold(_size(topic, kind))

    def _unadvertise(self, message: Message) -> None:
        topic = name_of(message, "topic")
        if topic in self._advertised:
            kind, end = self._advertised.pop(topic)
            self.budget.hold(-_size(topic, kind))
            end()

    def _publish(self, message: Message) -> None:
        topic = name_of(message, "topic")
        types = self._graph.topics.types
        kind = self._advertised[topic][0] if topic in self._advertised else types.get(topic)
        if kind is None:
            hint = suggestion(topic, types)
            raise BridgeError(f'there is no topic "{topic}"{hint}; advertise it with its type')
        content = from_plain(get(kind), message.get("msg", {}))
        if isinstance(message.get("msg"), dict):
            self._stamp(content, message["msg"])
        if topic not in self._advertised:  # as if it had been: it ends with the client
            self._advertise({"topic": topic, "type": kind})
        self._graph.publish(topic, content, self.budget)

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
        provider = self._providers.sessions.get(name)
        slim = {key: message[key] for key in _OF_ANSWERS if key in message}
        try:
            whole(message, "fragment_size", 0)  # of the answer
            if provider is None:
                # Its arguments may be many times larger than its text: they are read in its turn.
                answer = partial(self._answer, name, slim, self._data)
                refuse = partial(_response, slim, succeeded=False)
                self._calls.add(name, sys.getsizeof(self._data), answer, refuse)
            else:
                self._call_provider(name, provider, message, slim)
        except BridgeError as error:
            self._respond({**message, "fragment_size": None}, str(error), False)

    def _call_provider(
        self, name: str, provider: "RosbridgeSession", message: Message, slim: Message
    ) -> None:
        calls = self._providers.calls
        if sum(each.caller is self for each in calls.values()) >= MOST_CALLS:
            raise BridgeError(f"a client may make {MOST_CALLS} calls at a time")
        number = str(next(self._providers.numbers))
        call = {"op": "call_service", "id": number, "service": name}
        pieces = list(encoded({**call, "args": message.get("args", {})}, "none", 0))
        size = sys.getsizeof(self._data) + ENTRY
        self.budget.hold(size)
        calls[number] = Offered(self, slim, provider, size)
        for data in pieces:
            provider._outbox.reply(data, self.budget)

    def _answer(self, name: str, slim: Message, data: Data) -> Iterable[Data]:
        """Calls a service. Returns the response; on a thread of the pool."""
        arguments = message_of(data).get("args")
        arguments = {} if arguments is None else arguments
        if name in self._rosapi.services:
            asked = arguments if isinstance(arguments, dict) else {}
            return _response(slim, self._rosapi.services[name](asked), True)
        kind = self._graph.service_type(name)
        response = self._graph.call(name, from_plain(kind.request, arguments))
        return _response(slim, to_plain(response, cbor=slim.get("compression") == "cbor"), True)

    def _respond(self, call: Message, values: Any, succeeded: bool) -> None:
        for data in _response(call, values, succeeded):
            self._outbox.reply(data)

    def _advertise_service(self, message: Message) -> None:
        name = name_of(message, "service")
        if name in self._graph.services or name in self._rosapi.services:
            raise BridgeError(f'there is a service "{name}" already')
        if self._providers.sessions.get(name, self) is not self:
            raise BridgeError(f'another client offers the service "{name}"')
        self._withdraw(name)
        self._providers.sessions[name] = self
        self.budget.hold(_size(name))

    def _unadvertise_service(self, message: Message) -> None:
        self._withdraw(name_of(message, "service"))

    def _withdraw(self, name: str) -> None:
        """Offers a service no longer, if it is the client's."""
        if self._providers.sessions.get(name) is self:
            del self._providers.sessions[name]
            self.budget.hold(-_size(name))

    def _service_response(self, message: Message) -> None:
        number = str(message.get("id"))
        call = self._providers.calls.get(number)
        if call is not None and call.provider is self:
            self._providers.end_call(number)
            call.caller._respond(call.message, message.get("values"), message.get("result") is True)

    # Fragments, and messages about messages

    def _fragment(self, message: Message) -> None:
        number, total = whole(message, "num"), whole(message, "total")
        data, key = field(message, "data", str), f"{message.get('id')} {total}"
        if number >= total:
            raise BridgeError(f"num: expected less than total ({total}), found {number}")
        parts = self._fragments.setdefault(key, {})
        self.budget.hold(_size(key, data) - (_size(key, parts[number]) if number in parts else 0))
        parts[number] = data
        if len(parts) < total:
            return
        del self._fragments[key]
        self.budget.hold(-sum(_size(key, part) for part in parts.values()))
        text = "".join(parts[index] for index in range(total))
        if len(text) + sum(size * text.count(each) for each, size in _DECODED.items()) > _LARGEST:
            raise BridgeError(f"the fragments' message takes more than {_LARGEST} bytes")
        self.handle(text)

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

    def _send(self, message: Message) -> None:
        for data in encoded(message, "none", 0):
            self._outbox.reply(data)


def _agreed(wishes: Collection[_Wish]) -> Tuple[Encode, float, int]:
    """The encoding, throttle and length of a stream that serves all parts of a client.

    As rosbridge_suite does it, but with the longest queue, as the protocol says.
    """
    compression = max((each.compression for each in wishes), key=COMPRESSIONS.index)
    return (
        publisher(compression, min(each.fragment_size or sys.maxsize for each in wishes)),
        min(each.throttle for each in wishes),
        max(each.length for each in wishes),
    )


def _response(call: Message, values: Any, succeeded: bool) -> List[Data]:
    """The response to a call, in one or more pieces."""
    response = {"op": "service_response", "service": call.get("service"), **id_of(call)}
    form = str(call.get("compression")), whole(call, "fragment_size", 0)
    try:
        return list(encoded({**response, "values": values, "result": succeeded}, *form))
    except BridgeError as error:
        return list(encoded({**response, "values": str(error), "result": False}, *form))


def _size(*texts: str) -> int:
    """Bytes of an entry with some texts."""
    return ENTRY + sum(map(sys.getsizeof, texts))


def _ros1_name(kind: Any) -> str:
    """The name of a type, which clients may write as in ROS 2: "std_msgs/msg/String"."""
    if not isinstance(kind, str):
        raise MessageError(f"expected the name of a type, found {shortened(repr(kind))}")
    return kind.replace("/msg/", "/")

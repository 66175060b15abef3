"""One client of the Foxglove WebSocket protocol: Foxglove, Lichtblick.

https://github.com/foxglove/ws-protocol. Messages are those of ROS 1: `ros1`,
with `ros1msg` schemas; clients may also send JSON.
"""

import asyncio
import itertools
import struct
import uuid
from concurrent.futures import Executor
from functools import partial
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

import orjson

from flatland_bridge.budget import ENTRY, Budget
from flatland_bridge.client_calls import ClientCalls
from flatland_bridge.client_messages import (
    Message,
    decoded,
    field,
    items,
    message_of,
    name_of,
    whole,
    whole_numbers,
)
from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.outbox import Data, Outbox, Send, Stream
from flatland_bridge.plain_form import from_plain, plain_text, to_plain
from flatland_bridge.sample import Sample
from flatland_server.exceptions import FlatlandError, MessageError, shortened
from flatland_server.messages import deserialized, get, serialized

SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Equal in all that is used here."""

_MESSAGE_DATA, _TIME, _SERVICE_RESPONSE = 1, 2, 3  # from the server
_CLIENT_MESSAGE, _SERVICE_REQUEST = 1, 2
_JSON, _ROS1 = "json", "ros1"
_ENCODINGS = "expected the encoding json or ros1"
_ERROR = 2  # a level of status messages

_TOPICS_PERIOD = 0.2
"""Real time between two looks for new topics [s]."""
_MOST_TOPICS = 500
"""Topics that a client may subscribe to, or publish."""

_SESSION_ID = uuid.uuid4().hex


class _Channel(NamedTuple):
    """A topic that a client publishes to."""

    topic: str
    message_type: Any
    encoding: str
    end: Callable[[], None]


class FoxgloveSession:
    """Obeys a client, which is told what is wrong with its messages, and stays connected.

    Args:
        graph: the topics and services.
        pool: runs the calls of services.
        budget: counts all that is kept for the client.
    """

    def __init__(self, graph: Graph, pool: Executor, budget: Budget) -> None:
        self._graph = graph
        self._budget = budget
        self._outbox = Outbox(budget, pool)
        self._calls = ClientCalls(pool, budget, self._outbox)
        self._numbers = itertools.count(1)
        self._channels: Dict[int, Tuple[str, str]] = {}  # topics and types, by number
        self._services: Dict[int, str] = {}
        self._subscriptions: Dict[int, Tuple[int, Callable[[], None]]] = {}  # channel, end
        self._client_channels: Dict[int, _Channel] = {}
        self._operations: Dict[Any, Callable[[Message], None]] = {
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
            "advertise": self._advertise,
            "unadvertise": self._unadvertise,
        }
        self._send(
            {
                "op": "serverInfo",
                "name": "Flatland",
                "capabilities": ["clientPublish", "services", "time"],
                "supportedEncodings": [_JSON, _ROS1],
                "metadata": {},
                "sessionId": _SESSION_ID,
            }
        )
        self._follow_graph()

    def handle(self, data: Data) -> None:
        """Obeys a message of the client.

        Args:
            data: JSON text, or binary data.
        """
        try:
            if isinstance(data, bytes):
                self._handle_binary(data)
                return
            message = message_of(data)
            operation = field(message, "op", str)
            if operation not in self._operations:
                raise BridgeError(f'there is no operation "{shortened(str(operation))}"')
            self._operations[operation](message)
        except FlatlandError as error:
            self._outbox.reply(self.status(str(error)))
        except (ValueError, struct.error) as error:
            text = f"a message that does not follow the protocol: {shortened(repr(error))}"
            self._outbox.reply(self.status(text))

    async def run(self, send: Send) -> None:
        """Sends messages, and tells the client of new topics and services, for ever."""
        sending = asyncio.ensure_future(self._outbox.send_all(send))
        try:
            while not (await asyncio.wait([sending], timeout=_TOPICS_PERIOD))[0]:
                self._follow_graph()
                self._outbox.reply(struct.pack("<BQ", _TIME, self._graph.nanoseconds))
            await sending
        finally:
            sending.cancel()

    def status(self, text: str) -> Data:
        """A message that tells the client of an error."""
        return str(
            orjson.dumps({"op": "status", "level": _ERROR, "message": plain_text(text)}), "utf-8"
        )

    def close(self) -> None:
        """Ends all that the client has begun."""
        for _, end in self._subscriptions.values():
            end()
        for channel in self._client_channels.values():
            channel.end()
        self._outbox.close_all()
        self._calls.close()

    # What there is

    def _follow_graph(self) -> None:
        """Tells the client which topics and services have come or gone."""
        topics = set(self._graph.topics.published.items())
        gone = [number for number, each in self._channels.items() if each not in topics]
        for number in gone:
            del self._channels[number]
            for key in [key for key, (of, _) in self._subscriptions.items() if of == number]:
                self._end(key)
        if gone:
            self._send({"op": "unadvertise", "channelIds": gone})
        new = sorted(topics.difference(self._channels.values()))
        if new:
            numbered = {next(self._numbers): each for each in new}
            self._channels.update(numbered)
            channels = [_channel(number, *each) for number, each in numbered.items()]
            self._send({"op": "advertise", "channels": channels})
        services = self._graph.services
        ended = [number for number, name in self._services.items() if name not in services]
        for number in ended:
            del self._services[number]
        if ended:
            self._send({"op": "unadvertiseServices", "serviceIds": ended})
        known = set(self._services.values())
        added = {next(self._numbers): name for name in services if name not in known}
        if added:
            self._services.update(added)
            described = [_service(number, name, services[name]) for number, name in added.items()]
            self._send({"op": "advertiseServices", "services": described})

    # Topics

    def _subscribe(self, message: Message) -> None:
        for each in items(message, "subscriptions"):
            key, channel = whole(each, "id"), whole(each, "channelId")
            if channel not in self._channels:
                raise BridgeError(f"there is no channel {channel}")
            if key in self._subscriptions:
                raise BridgeError(f"there is a subscription of the id {key} already")
            if len(self._subscriptions) >= _MOST_TOPICS:
                raise BridgeError(f"a client may subscribe to {_MOST_TOPICS} topics")
            stream = Stream(_encoder(key), self._outbox.wake, self._budget, self._report)
            topic = self._channels[channel][0]
            end = self._graph.subscribe(topic, stream.receive, self._budget)
            self._outbox.open(key, stream)
            self._subscriptions[key] = channel, end
            self._budget.hold(ENTRY)

    def _unsubscribe(self, message: Message) -> None:
        for key in whole_numbers(message, "subscriptionIds"):
            self._end(key)

    def _end(self, key: int) -> None:
        self._outbox.close(key)
        subscription = self._subscriptions.pop(key, None)
        if subscription is not None:
            self._budget.hold(-ENTRY)
            subscription[1]()

    def _report(self, text: str) -> None:
        self._outbox.reply(self.status(text))

    def _advertise(self, message: Message) -> None:
        for each in items(message, "channels"):
            number, topic = whole(each, "id"), name_of(each, "topic")
            encoding = field(each, "encoding", str)
            if encoding not in (_JSON, _ROS1):
                raise BridgeError(f'{_ENCODINGS}, found "{shortened(encoding)}"')
            if len(self._client_channels) >= _MOST_TOPICS:
                raise BridgeError(f"a client may advertise {_MOST_TOPICS} topics")
            kind = get(field(each, "schemaName", str).replace("/msg/", "/"))
            self._withdraw(number)
            end = self._graph.advertise(topic, kind)
            self._client_channels[number] = _Channel(topic, kind, encoding, end)
            self._budget.hold(ENTRY)

    def _unadvertise(self, message: Message) -> None:
        for number in whole_numbers(message, "channelIds"):
            self._withdraw(number)

    def _withdraw(self, number: int) -> None:
        channel = self._client_channels.pop(number, None)
        if channel is not None:
            self._budget.hold(-ENTRY)
            channel.end()

    # Binary messages

    def _handle_binary(self, data: bytes) -> None:
        code, number = struct.unpack_from("<BI", data)
        if code == _CLIENT_MESSAGE:
            if number not in self._client_channels:
                raise BridgeError(f"channel {number} is not advertised")
            topic, kind, encoding, _ = self._client_channels[number]
            self._graph.publish(topic, _message(kind, encoding, data[5:]), self._budget)
        elif code == _SERVICE_REQUEST:
            call, length = struct.unpack_from("<II", data, 5)
            encoding = data[13 : 13 + length].decode()
            name = self._services.get(number, "")
            answer = partial(self._answer, name, number, call, encoding, data[13 + length :])
            self._calls.add(name, len(data), answer, partial(_failure, number, call))
        else:
            raise BridgeError(f"there is no binary operation {code}")

    def _answer(self, name: str, number: int, call: int, encoding: str, data: bytes) -> List[Data]:
        """Calls a service. Returns the response; on a thread of the pool."""
        kind = self._graph.service_type(name)
        response = self._graph.call(name, _message(kind.request, encoding, data))
        if encoding == _JSON:
            plain = to_plain(response)
            payload = bytes(orjson.dumps(plain, option=orjson.OPT_SERIALIZE_NUMPY))
        else:
            payload = serialized(response)
        head = struct.pack("<BIII", _SERVICE_RESPONSE, number, call, len(encoding))
        return [head + encoding.encode() + payload]

    def _send(self, message: Message) -> None:
        self._outbox.reply(orjson.dumps(message).decode())


def _failure(number: int, call: int, text: str) -> List[Data]:
    """The answer to a call that has failed."""
    failure = {"op": "serviceCallFailure", "serviceId": number, "callId": call}
    return [orjson.dumps({**failure, "message": plain_text(text)}).decode()]


def _encoder(key: int) -> Callable[[Sample], List[Data]]:
    """Makes the messages of a subscription."""
    return lambda sample: [
        struct.pack("<BIQ", _MESSAGE_DATA, key, sample.nanoseconds) + sample.data
    ]


def _schema(message_type: Any) -> Dict[str, Any]:
    return {"schemaName": message_type._type, "schemaEncoding": "ros1msg"}


def _channel(number: int, topic: str, kind: str) -> Dict[str, Any]:
    message_type = get(kind)
    channel = {"id": number, "topic": topic, "encoding": _ROS1, **_schema(message_type)}
    return {**channel, "schema": message_type._full_text}


def _service(number: int, name: str, kind: Any) -> Dict[str, Any]:
    """The description of a service; as of 2024, and with the fields of before."""
    service: Dict[str, Any] = {"id": number, "name": name, "type": kind.name}
    for part, message_type in (("request", kind.request), ("response", kind.response)):
        text = message_type._full_text
        service[part] = {"encoding": _ROS1, **_schema(message_type), "schema": text}
        service[f"{part}Schema"] = text
    return service


def _message(message_type: Any, encoding: str, data: bytes) -> Any:
    """A message of a client.

    Raises:
        MessageError: the data is none.
    """
    if encoding == _JSON:
        try:
            return from_plain(message_type, decoded(data.decode() or "{}"))
        except UnicodeDecodeError as error:
            raise MessageError(f"expected JSON: {error}") from None
    if encoding != _ROS1:
        raise BridgeError(f'{_ENCODINGS}, found "{shortened(encoding)}"')
    return deserialized(message_type, data, "strict")

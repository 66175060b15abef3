"""Random messages to a bridge: all operations, values of all types of JSON and CBOR."""

import base64
import copy
import json
import random
import struct
from typing import Any, Callable, Dict, List, Tuple

import cbor2
from soak.bridge_process import Data
from soak.bridge_witnesses import FUZZED
from soak.mutations import NUMBERS, ODD
from soak.random_messages import INTEGERS, WORDS

from flatland_server.messages.message_types import get
from flatland_server.messages.wire_form import serialized

PLANTED = "planted_by_soak"
"""A module that writes a file when it is imported."""
TYPES = (
    *("", "x", "/", "std_msgs/", "std_msgs/msg/String", "std_msgs/Nope", "a/b/c", "../x"),
    "os/path",
    *("__main__/X", f"{PLANTED}/X", f"{PLANTED}/msg/X", f"{PLANTED}.x/X", "std_msgs/__init__"),
    *FUZZED.values(),
)  # fmt: skip
NAMES = (
    *("", "/", "//", "a b", "~x", "/cmd_vel", "/scan", "/tf", "/nope", "ü", "x" * 2000),
    "/fuzzed_0/x",
)
ABOUT_TYPES = ("/rosapi/message_details", "/rosapi/service_request_details")
ABOUT_PARAMETERS = tuple(
    f"/rosapi/{verb}_param" for verb in ("set", "get", "has", "search", "delete")
)
NOT_CALLED = ("open_world", "reload_world", "load_world", "unload_world")
"""They would take the honest clients' topics away."""
RAW = "raw-value-of-the-soak"
"""Takes the place of a value that no library would write."""
JSON_VALUES = (
    *("1e999", "-1e999", "1" * 5000, "1e1000000", "0." + "0" * 5000 + "1", "NaN", "-Infinity"),
    *("[" * 100_000, "[" * 900 + "]" * 900, '{"a":' * 900 + "1" + "}" * 900, '"\\ud800"', "01"),
    *("1e-400", "18446744073709551616", "-9223372036854775809", '{"a":1,"a":2}', "tru", '"', "[1,"),
    *("600000000", "2147483648", "4294967296", "1e6", "9007199254740993.0"),
)  # fmt: skip
CBOR_VALUES = tuple(map(bytes.fromhex, [
    "c4821a000f424001", "c4821b7fffffffffffffff01", "c4823a000f423f01",  # decimals: 1e1000000 ...
    "c5821a3b9aca0001", "c5823a3b9ac9ff01",  # bigfloats: 2 ** 1e9, 2 ** -1e9
    "c249010000000000000000", "c349010000000000000000", "c25a00002710" + "ff" * 10_000,  # integers
    "c063323031", "c074323031332d30332d32315432303a30343a30305a", "c1fb7ff0000000000000",
    "c11bffffffffffffffff", "c1fb7ff8000000000000", "d864390fff",  # times
    "d903ec6a323031332d30332d3231",
    "d81e820100", "d81e8201c4821a000f424001", "d81e82f9000001",  # rationals
    "d82363282828", "d8236628612b292b24", "d8246568656c6c6f", "d8254401020304",
    "d9010444ffffffff", "d9010443010203", "d90105a144c0a8006420",  # regexps, MIME, UUIDs, addresses
    "d81c81d81d00", "d81ca16161d81d00", "d81d05", "d81c82d81c81d81d00d81d01",  # shared, cyclic
    "d90100836161d81900d81901", "d81900", "d9010281f90000", "d901028180", "d9010281a0",  # sets
    "d84543010203", "d84641ff", "d84749ffffffffffffffffff", "d8554401020304", "d8564100", "d85040",
    "d84501", "d845820102", "d84080", "d8456161", "d9a7f88201fb7ff8000000000000",  # typed arrays
    "f7", "f8ff", "f820", "f97e00", "f97c00", "fbfff0000000000000", "fb7fefffffffffffff",
    "1bffffffffffffffff", "3bffffffffffffffff", "1a7fffffff", "1a23c34600", "f4", "f6", "40", "60",
    "9f", "5f", "7f", "bf", "ff", "9fff", "5f4101ff", "7f6161ff", "5f6161ff", "1c", "1f", "fc",
    "9bffffffffffffffff", "9b7fffffffffffffff", "9a7fffffff", "bbffffffffffffffff", "ba7fffffff",
    "5bffffffffffffffff", "5b7fffffffffffffff", "5a7fffffff", "7bffffffffffffffff", "7a7fffffff",
    "a1818001", "a1a00001", "a1f701", "a10102", "a1d901028001", "d9d9f701",
    "81" * 5_000 + "80", "81" * 200_000, "d9d9f7" * 5_000 + "01",
    "62c328", "63eda080", "6161", "64f09f9880",  # text that is not UTF-8
]))  # fmt: skip
LENGTHS = tuple(
    struct.pack("<I", each) for each in (2**32 - 1, 2**31, 2**31 - 1, 600_000_000, 2**24, 2**16, 1)
)
ODD_VALUES = (*NUMBERS, *ODD, *WORDS)


class RandomMessages:
    """Makes messages of clients.

    Args:
        rng: generator of all random choices.
        topics: types of the topics to publish on, by name.
        services: classes of requests, by the services' names.
    """

    def __init__(
        self, rng: random.Random, topics: Dict[str, str], services: Dict[str, Any]
    ) -> None:
        self._rng = rng
        self._topics = topics
        self._services = services
        self._turn: List[Tuple[int, str]] = []
        self._operations: Dict[str, List[str]] = {
            "advertise": ["topic", "type", "latch", "queue_size"],
            "advertise_service": ["service", "type"],
            "auth": ["mac", "client", "rand"],
            "call_service": ["service", "args", "fragment_size", "compression"],
            "fragment": ["num", "total", "data"],
            "publish": ["topic", "msg"],
            "service_response": ["service", "values", "result"],
            "set_level": ["level"],
            "status": ["level", "msg"],
            "subscribe": [
                *("topic", "type", "throttle_rate", "queue_length", "fragment_size", "compression"),
            ],
            "unadvertise": ["topic"],
            "unadvertise_service": ["service"],
            "unsubscribe": ["topic"],
        }

    # rosbridge

    def rosbridge(self) -> Data:
        """A message of rosbridge, as JSON or as CBOR."""
        return self._encoded(self._message(), is_cbor=self._rng.random() < 0.6)

    def _message(self) -> Dict[str, Any]:
        rng = self._rng
        operation = rng.choice([*self._operations, *["publish", "call_service"] * 5])
        message: Dict[str, Any] = {"op": operation, "id": rng.choice(["a", "b", 7])}
        topic = rng.choice([*self._topics, *self._topics, *NAMES])
        ours = (*ABOUT_TYPES, *ABOUT_PARAMETERS)
        service = rng.choice([*self._services, *self._services, *ours, *NAMES])
        kind = self._topics.get(topic) or rng.choice(TYPES)
        valid: Dict[str, Callable[[], Any]] = {
            "topic": lambda: topic,
            "type": lambda: rng.choice([kind, kind, *TYPES]),
            "service": lambda: service,
            "msg": lambda: self._content(kind),
            "args": lambda: self._request(service),
            "values": lambda: self._request(service),
            "compression": lambda: rng.choice(["none", "cbor", "cbor-raw", "png", "x"]),
            "level": lambda: rng.choice(["none", "error", "warning", "info", "x"]),
            "num": lambda: rng.choice([0, 1, 2, 1e9]),
            "total": lambda: rng.choice([1, 2, 3, 1e9, 2**70]),
            "data": lambda: json.dumps({"op": "status"})[: rng.choice([3, 99])],
        }
        for field in self._operations[operation]:
            if rng.random() < 0.9:
                message[field] = valid.get(field, lambda: rng.choice([0, 1, 100]))()
        if rng.random() < 0.3:
            message[rng.choice([*message, "id"])] = self._odd()
        return message

    def _encoded(self, message: Any, *, is_cbor: bool) -> Data:
        rng = self._rng
        if is_cbor:
            data = cbor2.dumps(message, default=lambda encoder, value: encoder.encode(repr(value)))
            data = data.replace(cbor2.dumps(RAW), rng.choice(CBOR_VALUES))
            return self._spoilt(data)
        text = json.dumps(message, default=lambda value: base64.b64encode(bytes(value)).decode())
        text = text.replace(f'"{RAW}"', rng.choice(JSON_VALUES))
        return text if rng.random() < 0.9 else text[: rng.randrange(len(text) + 1)]

    def _spoilt(self, data: bytes) -> bytes:
        """Now and then cut, with other bytes, or with a length that is a lie."""
        rng, at = self._rng, self._rng.randrange(len(data) + 1)
        return rng.choice(
            [
                *[data] * 6,
                data[:at],
                data[:at] + bytes(rng.randrange(256) for _ in range(4)) + data[at + 4 :],
                data[:at] + rng.choice(LENGTHS) + data[at + 4 :],
                data + b"\xff" * rng.choice([1, 1000]),
            ]
        )

    # Contents

    def _request(self, service: str) -> Any:
        if service in ABOUT_TYPES:
            return {"type": self._rng.choice(TYPES)}
        if service in ABOUT_PARAMETERS:
            value = self._rng.choice([json.dumps(self._rng.choice(WORDS)), *JSON_VALUES])
            return {"name": self._rng.choice(NAMES), "value": value, "default": self._odd()}
        kind = self._services.get(service)
        return self._content(kind._type) if kind else self._odd()

    def _content(self, type_name: str) -> Any:
        """A message's fields: most of the right type, at their limits or beyond."""
        rng = self._rng
        try:
            kind = get(type_name)
        except Exception:
            return self._odd()
        fields = zip(kind.__slots__, kind._slot_types)
        content = {name: self._value(each) for name, each in fields if rng.random() < 0.9}
        if rng.random() < 0.1:
            content[rng.choice(["nope", "", "header", "__class__"])] = self._odd()
        return list(content.values()) if rng.random() < 0.05 else content

    def _value(self, field_type: str) -> Any:
        rng = self._rng
        base, bracket, length = field_type.partition("[")
        base = "std_msgs/Header" if base == "Header" else base
        if rng.random() < 0.1:
            return self._odd()
        if bracket:
            usual = int(length[:-1]) if length != "]" else rng.choice([0, 1, 3])
            count = rng.choice([usual, usual, usual, usual + 1, 500])
            if base in ("uint8", "char"):
                data = bytes(count)
                return rng.choice([data, base64.b64encode(data).decode(), list(data), count])
            return [self._value(base) for _ in range(min(count, 3 if "/" in base else count))]
        if "/" in base:
            return self._content(base)
        if base in ("time", "duration"):
            parts = [rng.choice([0, 1, -1, 2**31, 2**32, 10**9, 0.5]) for _ in range(2)]
            return dict(zip(rng.choice([("secs", "nsecs"), ("sec", "nanosec")]), parts))
        if base == "string":
            return rng.choice(WORDS)
        if base == "bool":
            return rng.choice([True, False, 0, 1, 2, None])
        low, high = INTEGERS.get(base, (-1e308, 1e308))
        return rng.choice([0, 1, low, high, low - 1, high + 1, 0.5, -1, 1e30, 300])

    def _odd(self) -> Any:
        return RAW if self._rng.random() < 0.4 else copy.deepcopy(self._rng.choice(ODD_VALUES))

    # Foxglove's protocol

    def foxglove(self, channels: List[int], services: Dict[int, str]) -> Data:
        """A message of Foxglove's protocol, as JSON or binary.

        Args:
            channels: numbers of the server's channels.
            services: names of the server's services, by their numbers.
        """
        rng = self._rng
        if rng.random() < 0.6:
            return self._spoilt(self._binary(services))
        number = rng.choice([*channels, 0, 2**32, -1, 0.5])
        topic = rng.choice([*self._topics, *NAMES])
        channel = {"id": rng.randrange(5), "topic": topic, "encoding": rng.choice(["json", "ros1"])}
        channel["schemaName"] = rng.choice([self._topics.get(topic, ""), *TYPES])
        numbers = [rng.randrange(9)]
        message: Dict[str, Any] = {
            **{"op": rng.choice(["advertise", "unadvertise", "subscribe", "unsubscribe", "x"])},
            "channels": [channel] * rng.choice([0, 1, 1, 3]),
            "subscriptions": [{"id": rng.choice([0, 1, 2**32 - 1]), "channelId": number}],
            **{"channelIds": numbers, "subscriptionIds": numbers},
        }
        if rng.random() < 0.4:
            target: Any = rng.choice([message, message, channel, message["subscriptions"][0]])
            target[rng.choice(list(target))] = self._odd()
        return self._encoded(message, is_cbor=False)

    def _binary(self, services: Dict[int, str]) -> bytes:
        rng = self._rng
        if not self._turn:  # each service has its turn
            self._turn = [*services.items(), (2**32 - 1, "")]
            rng.shuffle(self._turn)
        number, name = self._turn.pop()
        encoding = rng.choice([b"json", *[b"ros1"] * 4, b"cdr", b"\xff\xfe"])
        kind = self._services.get(name) or get(rng.choice(list(FUZZED.values())))
        if encoding == b"json":
            payload = self._encoded(self._content(kind._type), is_cbor=False)
            payload = (
                payload.encode(errors="surrogatepass") if isinstance(payload, str) else payload
            )
        else:
            payload = self._lying(serialized(kind()))
        if rng.random() < 0.2:
            return struct.pack("<BI", 1, rng.randrange(5)) + payload
        length = rng.choice([len(encoding)] * 5 + [0, 2**32 - 1, 2**31])
        return (
            struct.pack("<BIII", rng.choice([2, 2, 2, 3, 255]), number, 1, length)
            + encoding
            + payload
        )

    def _lying(self, data: bytes) -> bytes:
        """A serialized message with a length, if it has one, that is a lie."""
        at = self._rng.choice([0, 0, 0, 4, self._rng.randrange(len(data) + 1)])
        return data[:at] + self._rng.choice([*LENGTHS, b""]) + data[at + 4 :]


def known_services(names: Dict[str, str]) -> Dict[str, Any]:
    """Classes of requests by the services' names, of the types' names."""
    from flatland_bridge import simulation_types
    from flatland_server.messages import service_types

    found: Dict[str, Any] = {}
    for name, kind in names.items():
        if name.strip("/").startswith(NOT_CALLED):
            continue
        package, _, bare = kind.partition("/")
        is_standard = package == simulation_types.PACKAGE
        found[name] = (
            simulation_types.service(bare) if is_standard else service_types.get(kind)
        ).request
    return found

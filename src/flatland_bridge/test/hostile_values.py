"""Fields of all kinds against values of all kinds, in JSON, CBOR and bytes.

A program, so that memory and processor time can be limited, and ROS be left out: a value that takes
too much of them ends it.
"""

import json
import random
import resource
import struct
from collections import Counter

import cbor2
import orjson

from flatland_bridge.client_messages import decoded
from flatland_bridge.graph import BridgeError
from flatland_bridge.plain_form import from_plain, to_plain
from flatland_server import MessageError, messages
from flatland_server.messages.definition import BUILT_IN
from flatland_server.messages.message_types import deserialized
from flatland_server.messages.standard_definitions import standard_definitions
from flatland_server.messages.wire_form import serialized

MEMORY = 200 << 20
"""Bytes that the program may take, besides those of its modules."""
CPU_TIME = 60  # s
LIES = (1, 2**16, 2**31 - 1, 2**32 - 1)

# fmt: off
NUMBERS = (
    *(0, 1, -1, 3.0, 0.5, -0.0, 1e30, -1e30, 1e308, 3.4028235e38, 3.5e38, 5e-324),
    *(2**bits + off for bits in (7, 8, 15, 16, 31, 32, 63) for off in (-1, 0)),
    *(-(2**bits) + off for bits in (7, 15, 31, 63) for off in (-1, 0)),
    *(2**64 - 1, 600_000_000),
)
PLAIN = (
    *NUMBERS,
    *(None, True, False, "", "7", "1e9", "AAEC", "AA=", "ä\0", [], {}, [1], [0.5] * 3, [None] * 3),
    *(["x"] * 3, [256], [-1, 2], [[]], [{}], [1, "2"], [0] * 2000, [{}] * 300, [[]] * 300),
    *({"secs": -1}, {"secs": 2**32}, {"secs": 1e30}, {"secs": 2**32 - 1, "nsecs": 2**31}),
    *({"secs": -(2**31), "nsecs": -1}, {"nsecs": "1"}, {"sec": 1, "nanosec": 2}, {"x": {"x": {}}}),
)
JSON = (
    *("1e999", "-1e999", "1E1000000", "1" + "0" * 5000, "NaN", '"\\ud800"', '"\\u0000"'),
    *("[" * depth + "]" * depth for depth in (50, 150, 900, 2000)),
    *('{"a":' * depth + "1" + "}" * depth for depth in (150, 900)),
    "[" + "{}," * 100_000 + "{}]",
    '{"data":' + "[[]," * 100 + "1" + "]" * 100 + "}",
)


def tagged(number, content):
    return cbor2.dumps(cbor2.CBORTag(number, content))


CBOR = (
    *(b"\xf7", b"\xe0", b"\xf8\x20", b"\xf8\xff", b"\xff", b"\xfa\x7f\x80\x00\x00"),
    *(b"\xfb" + b"\xff" * 8, b"\x3b" + b"\xff" * 8, b"\x1b" + b"\xff" * 8, b"\x1c"),
    *(b"\xf9\x7e\x00", b"\x9f\x01\xff", b"\x5f\x41a\xff", b"\x7f\x61a\xff", b""),
    *(bytes([kind]) + b"\xff" * 8 for kind in (0x5B, 0x7B, 0x9B, 0xBB)),
    *(bytes([kind]) + struct.pack(">Q", 2**32) for kind in (0x5B, 0x7B, 0x9B, 0xBB)),
    *(bytes([kind]) + b"\xff" * 4 for kind in (0x5A, 0x7A, 0x9A, 0xBA)),
    *(b"\x81" * depth + b"\x00" for depth in (90, 150, 5000)),
    *(b"\xa1\x61a" * depth + b"\x00" for depth in (150, 5000)),
    *(b"\xa1\x01\x02", b"\xa1\xf6\x02", b"\xa1\x80\x02", b"\xa1\x41a\x02", b"\x62\xff\xff"),
    tagged(0, "2020-01-01T00:00:00Z"),
    tagged(1, 1e300),
    *(tagged(number, bytes([255]) * 100_000) for number in (2, 3)),
    *(tagged(number, [10**9, 1]) for number in (4, 5)),
    *(tagged(number, [-(10**9), 1]) for number in (4, 5)),
    b"\xc4\x82\x1a\x00\x0f\x42\x40\x01",  # 1e1000000
    tagged(30, [1, 3]),
    tagged(30, [10**4000, 7**4000]),
    tagged(35, "(" * 1000 + "a+" + ")+" * 1000),
    tagged(36, "MIME-Version: 1.0\n\nx"),
    tagged(37, bytes(16)),
    *(tagged(number, [1, 2]) for number in (258, 260, 261, 43000, 1004, 100, 55799, 10**9)),
    b"\xd8\x1c\x81\xd8\x1d\x00",  # a list that contains itself
    b"\xd8\x1c\xa1\x61a\xd8\x1d\x00",
    b"\xd9\x01\x00\x82\x64aaaa\xd8\x19\x00",
    tagged(54, b"\xc0\xa8\x00\x01"),
    tagged(52, b"\xc0\xa8\x00\x01"),
    *(tagged(number, bytes(24)) for number in range(64, 88)),
    *(tagged(number, bytes([255]) * 24) for number in range(64, 88)),
    *(tagged(number, content) for number in (64, 69, 86) for content in (b"abc", "abc", [1])),
)


TYPES = (
    *(name for name in standard_definitions() if name.startswith("std_msgs/")),
    *("geometry_msgs/PoseWithCovarianceStamped", "nav_msgs/Path", "rosgraph_msgs/Log"),
    *("sensor_msgs/CameraInfo", "sensor_msgs/Image", "sensor_msgs/JointState"),
    *("tf2_msgs/TFMessage", "visualization_msgs/MarkerArray"),
)
# fmt: on


def types():
    """Types with fields of all kinds: our own, and common ones, which are ROS's if there is ROS."""
    kinds = [kind for base in BUILT_IN for kind in (base, f"{base}[]", f"{base}[3]")]
    for name in ("std_msgs/Empty", "geometry_msgs/PoseStamped", "geometry_msgs/PoseWithCovariance"):
        kinds += [name, f"{name}[]", f"{name}[3]"]
    own = [messages.add(f"hostile/Kind{index}", f"{kind} f") for index, kind in enumerate(kinds)]
    nested = messages.add(
        "hostile/Nested", "nav_msgs/Path[] paths\nstd_msgs/Empty[] none\nKind5[2] two"
    )
    return [*own, nested, *map(messages.get, TYPES)]


def values():
    """Values as JSON or CBOR."""
    for value in PLAIN:
        yield json.dumps(value)
        yield cbor2.dumps(value)
    yield from JSON
    yield from CBOR


def attempt(function, *arguments):
    """The result of a function; None if it refuses the arguments, in a few words."""
    try:
        return function(*arguments)
    except (BridgeError, MessageError) as refusal:
        text = str(refusal)
    assert len(text) < 1000, text
    return None


def check(message):
    """A message is one that can be sent in all encodings."""
    data = serialized(message)
    assert serialized(deserialized(type(message), data)) == data
    check_plain(message)


def check_plain(message):
    orjson.dumps(to_plain(message), option=orjson.OPT_SERIALIZE_NUMPY)
    cbor2.dumps(to_plain(message, cbor=True))


def plain_values(counts):
    """Values of all kinds in fields of all kinds, and instead of a message."""
    kinds = types()
    for data in values():
        value = attempt(decoded, data)
        counts["taken" if value is not None or data in ("null", b"\xf6") else "refused"] += 1
        if value is None:
            continue
        for kind in kinds:
            for fields in ({name: value} for name in kind.__slots__):
                message = attempt(from_plain, kind, fields)
                counts["taken" if message else "refused"] += 1
                if message is not None:
                    check(message)
            attempt(from_plain, kind, value)


def wire_values(counts):
    """Bytes: messages that are cut, extended, and changed, with lengths that are lies."""
    chance = random.Random(5)
    for kind in types():
        message = kind()
        for name, field in zip(kind.__slots__, kind._slot_types):
            if field.endswith("[]") and "/" in field:
                setattr(message, name, [messages.get(field[:-2])()])
        sound = serialized(message)
        for _ in range(25):
            data = bytearray(sound[: chance.choice((None, chance.randrange(len(sound) + 1)))])
            for _ in range(chance.randrange(4)):
                at = chance.randrange(len(data) + 1)
                data[at : at + 4] = struct.pack(
                    "<I", chance.choice((chance.randrange(2**32), *LIES))
                )
            message = attempt(deserialized, kind, bytes(data), "strict")
            counts["taken" if message else "refused"] += 1
            if message is not None:
                check(message)
            message = attempt(deserialized, kind, bytes(data))
            if message is not None:
                check_plain(message)


def limit():
    with open("/proc/self/statm") as file:
        taken = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY,) * 2)
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_TIME,) * 2)


def main():
    """Prints how many values were taken and refused."""
    limit()
    for try_all in (plain_values, wire_values):
        counts = Counter()
        try_all(counts)
        print(json.dumps(counts))


if __name__ == "__main__":
    main()

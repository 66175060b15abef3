"""Messages of the rosbridge protocol as JSON, CBOR and fragments."""

import itertools
from typing import Any, Callable, Iterable, List, Mapping, Optional

import cbor2
import orjson

from flatland_bridge.graph import BridgeError, Sample
from flatland_bridge.outbox import Data
from flatland_bridge.plain_form import read_tag, to_plain
from flatland_server.exceptions import shortened

COMPRESSIONS = ("none", "cbor", "cbor-raw")

Message = Mapping[str, Any]


def encoded(message: Message, compression: str, fragment_size: Optional[int]) -> Iterable[Data]:
    """A message, in one or more pieces.

    Args:
        message: the message.
        compression: "cbor", or anything else for JSON.
        fragment_size: longest text of JSON [characters], without the fragment's own fields.
    """
    if compression == "cbor":
        return [bytes(cbor2.dumps(message))]
    return _fragments(_json(message), fragment_size)


def decoded(data: Data) -> Any:
    """A message of a client.

    Args:
        data: JSON text, or CBOR bytes.

    Raises:
        BridgeError: it is neither.
    """
    try:
        return orjson.loads(data) if isinstance(data, str) else cbor2.loads(data, tag_hook=read_tag)
    except (orjson.JSONDecodeError, cbor2.CBORDecodeError, RecursionError) as error:
        kind = "JSON" if isinstance(data, str) else "CBOR"
        raise BridgeError(f"expected {kind}: {shortened(str(error))}") from None


_fragment_numbers = itertools.count(1)
_SMALLEST_FRAGMENT = 200
"""Characters. The parts of smaller ones would keep the event loop busy for all clients."""


def _fragments(text: str, size: Optional[int]) -> Iterable[str]:
    """A text, in fragments if it is longer than a size."""
    if not size or len(text) <= size:
        return [text]
    size = max(size, _SMALLEST_FRAGMENT)
    parts = [text[begin : begin + size] for begin in range(0, len(text), size)]
    name = str(next(_fragment_numbers))
    head = {"op": "fragment", "id": name, "total": len(parts)}
    return [_json({**head, "num": index, "data": part}) for index, part in enumerate(parts)]


def publisher(compression: str, fragment_size: Optional[int]) -> Callable[[Sample], List[Data]]:
    """Makes what a client gets of each message of a topic.

    Args:
        compression: one of `COMPRESSIONS`.
        fragment_size: as for `encoded`.
    """

    def publish(sample: Sample) -> List[Data]:
        if compression not in sample.encodings:
            sample.encodings[compression] = _ENCODERS[compression](sample)
        data = sample.encodings[compression]
        if compression != "none":
            return [data]
        return list(_fragments(data.decode(), fragment_size))

    return publish


def _publish_json(sample: Sample) -> bytes:
    head = orjson.dumps({"op": "publish", "topic": sample.topic})[:-1]
    content = orjson.dumps(to_plain(sample.message), option=orjson.OPT_SERIALIZE_NUMPY)
    return b"".join([head, b',"msg":', content, b"}"])


def _publish_cbor(sample: Sample) -> bytes:
    content = to_plain(sample.message, cbor=True)
    return bytes(cbor2.dumps({"op": "publish", "topic": sample.topic, "msg": content}))


def _publish_raw(sample: Sample) -> bytes:
    seconds, nanoseconds = divmod(sample.nanoseconds, 1_000_000_000)
    content = {"bytes": sample.data, "secs": seconds, "nsecs": nanoseconds}
    return bytes(cbor2.dumps({"op": "publish", "topic": sample.topic, "msg": content}))


_ENCODERS = {"none": _publish_json, "cbor": _publish_cbor, "cbor-raw": _publish_raw}


def _json(message: Message) -> str:
    return str(orjson.dumps(message, option=orjson.OPT_SERIALIZE_NUMPY), "utf-8")

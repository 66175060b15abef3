"""Messages of the rosbridge protocol as JSON, CBOR and fragments."""

import base64
import itertools
from typing import Any, Callable, Iterable, List

import cbor2
import orjson

from flatland_bridge.client_messages import Message
from flatland_bridge.graph import BridgeError
from flatland_bridge.outbox import Data
from flatland_bridge.plain_form import to_plain
from flatland_bridge.sample import Sample
from flatland_server.exceptions import shortened

COMPRESSIONS = ("none", "cbor", "cbor-raw")
"""Of several wishes for a topic, the last one of these counts."""


def encoded(message: Message, compression: str, fragment_size: int) -> Iterable[Data]:
    """A message, in one or more pieces.

    Args:
        message: the message.
        compression: "cbor", or anything else for JSON.
        fragment_size: longest text of JSON [characters], without the fragment's own fields; 0 is
            any.

    Raises:
        BridgeError: a value cannot be encoded.
    """
    try:
        if compression == "cbor":
            return [bytes(cbor2.dumps(message, default=_encode_array))]
        return _fragments(_json(message), fragment_size)
    except (TypeError, ValueError, cbor2.CBOREncodeError) as error:
        raise BridgeError(f"an answer cannot be sent: {shortened(str(error))}") from None


_fragment_numbers = itertools.count(1)
_SMALLEST_FRAGMENT = 200
"""Characters. The parts of smaller ones would keep the event loop busy for all clients."""


def _fragments(text: str, size: int) -> Iterable[str]:
    """A text, in fragments if it is longer than a size."""
    if not size or len(text) <= size:
        return [text]
    size = max(size, _SMALLEST_FRAGMENT)
    parts = [text[begin : begin + size] for begin in range(0, len(text), size)]
    name = str(next(_fragment_numbers))
    head = {"op": "fragment", "id": name, "total": len(parts)}
    return [_json({**head, "num": index, "data": part}) for index, part in enumerate(parts)]


def publisher(compression: str, fragment_size: int) -> Callable[[Sample], List[Data]]:
    """Makes what a client gets of each message of a topic.

    Args:
        compression: one of `COMPRESSIONS`.
        fragment_size: as for `encoded`.

    Returns:
        A function that raises a BridgeError if a message has a wrong value.
    """

    def publish(sample: Sample) -> List[Data]:
        try:
            data = sample.encoded(compression, _ENCODERS[compression])
        except Exception as error:  # ROS's classes raise all kinds
            text = f'a message of "{sample.topic}" cannot be sent: {shortened(str(error))}'
            raise BridgeError(text) from None
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
    return str(orjson.dumps(message, _to_text, orjson.OPT_SERIALIZE_NUMPY), "utf-8")


def _to_text(value: Any) -> str:
    """The text of bytes that a client has sent to another."""
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    raise TypeError(f"expected plain values, found {value!r}")


def _encode_array(encoder: Any, value: Any) -> None:
    """Encodes an array that a client has sent to another."""
    encoder.encode(value.tolist())

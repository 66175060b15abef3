"""Messages of clients as plain values, and their fields: checked before use.

Plain values are those of JSON, and of CBOR also bytes and NumPy's arrays.
"""

from typing import Any, Callable, Dict, List, Mapping, Optional, Type, TypeVar

import cbor2
import numpy as np
import orjson

from flatland_bridge.graph import BridgeError
from flatland_bridge.outbox import Data
from flatland_bridge.plain_form import TYPED_ARRAYS, shown
from flatland_server.config import is_topic
from flatland_server.exceptions import shortened
from flatland_server.transport import absolute_name

try:
    cbor2.loads(b"\xf6", semantic_decoders={}, strict_hashable_types=True)
except TypeError:  # it would decode all tags
    raise ImportError("expected cbor2 6.2 or newer", name="cbor2 6.2 or newer") from None

MOST_DEPTH = 100
"""Arrays and objects within each other."""
_LEAVES = (type(None), bool, float, str, bytes, np.ndarray)
_UINT32 = 2**32 - 1

Message = Mapping[str, Any]

T = TypeVar("T")


def decoded(data: Data) -> Any:
    """The plain values of a message.

    Args:
        data: JSON text, or CBOR bytes.

    Raises:
        BridgeError: it is neither, or has values of other kinds.
    """
    kind = "JSON" if isinstance(data, str) else "CBOR"
    try:
        if isinstance(data, str):
            value = orjson.loads(data)
            if len(data) > 2 * MOST_DEPTH and data.count("[") + data.count("{") > MOST_DEPTH:
                _check(value)  # it may be deep, and is plain otherwise
        else:
            value = cbor2.loads(data, semantic_decoders=_TAGS, strict_hashable_types=True)
            _check(value)
    except (ValueError, cbor2.CBORDecodeError) as error:
        raise BridgeError(f"expected {kind}: {shortened(str(error.__cause__ or error))}") from None
    return value


def _check(value: Any) -> None:
    """Raises a ValueError unless a value is plain."""
    level = [value]
    for _ in range(MOST_DEPTH):
        below: List[Any] = []
        for each in level:
            kind = type(each)
            if kind is list:
                below += each
            elif kind is dict:
                if not all(type(key) is str for key in each):
                    raise ValueError("expected names of fields as text")
                below += each.values()
            elif kind is int:
                if not -(2**63) <= each < 2**64:
                    raise ValueError(f"expected integers of 64 bits, found {each}")
            elif kind not in _LEAVES:
                raise ValueError(f"expected plain values, found {shown(each)}")
        if not below:
            return
        level = below
    raise ValueError(f"expected {MOST_DEPTH} levels of arrays and objects or fewer")


class _Tags(Dict[int, Callable[[Any, bool], Any]]):
    """Decodes typed arrays. cbor2 would decode many other tags by itself."""

    def __missing__(self, tag: int) -> Callable[[Any, bool], Any]:
        dtype = TYPED_ARRAYS.get(tag)

        def decode(value: Any, is_immutable: bool) -> Any:
            if type(value) is not bytes or dtype is None:
                raise ValueError(f"expected tags of typed arrays alone, found the tag {tag}")
            return np.frombuffer(value, dtype)

        return decode


_TAGS = _Tags()


def message_of(data: Data) -> Message:
    """A message of a client: an object with an operation.

    Args:
        data: JSON text, or CBOR bytes.

    Raises:
        BridgeError: it is something else, or its id is neither text nor a number.
    """
    message = decoded(data)
    if not isinstance(message, dict):
        raise BridgeError(f"expected an object, found {shown(message)}")
    id_of(message)
    return message


def id_of(message: Message) -> Dict[str, Any]:
    """The field `id` of a message, for its answer; empty if it has none.

    Raises:
        BridgeError: it is neither text nor a number.
    """
    value = message.get("id")
    if value is not None and not isinstance(value, (str, int, float)):
        raise BridgeError(f"id: expected text or a number, found {shown(value)}")
    return {} if value is None else {"id": value}


def field(message: Message, key: str, kind: Type[T]) -> T:
    """A field of a message.

    Args:
        message: a message of a client.
        key: key of the field.
        kind: str, list or dict.

    Raises:
        BridgeError: it is of another kind, or missing.
    """
    value = message.get(key)
    if not isinstance(value, kind):
        raise BridgeError(f"{key}: expected {_NAMES[kind]}, found {shown(value)}")
    return value


_NAMES: Dict[type, str] = {str: "text", list: "an array", dict: "an object"}


def items(message: Message, key: str) -> List[Message]:
    """The objects in a field of a message.

    Raises:
        BridgeError: it has something else.
    """
    found = field(message, key, list)
    for each in found:
        if not isinstance(each, dict):
            raise BridgeError(f"{key}: expected objects, found {shown(each)}")
    return found


def name_of(message: Message, key: str) -> str:
    """The absolute name of a topic or service in a field of a message.

    Raises:
        BridgeError: it has something else.
    """
    name = message.get(key)
    if not isinstance(name, str) or not is_topic(name):
        raise BridgeError(f"expected a name as {key}, found {shown(name)}")
    return absolute_name(name)


def whole(message: Message, key: str, default: Optional[int] = None) -> int:
    """A whole number of 32 bits in a field of a message.

    Args:
        message: a message of a client.
        key: key of the field.
        default: value of a missing field.

    Raises:
        BridgeError: it is something else, or missing without a default.
    """
    value = message.get(key)
    return default if value is None and default is not None else _whole(key, value)


def whole_numbers(message: Message, key: str) -> List[int]:
    """The whole numbers of 32 bits in an array of a message.

    Raises:
        BridgeError: it has something else.
    """
    return [_whole(key, each) for each in field(message, key, list)]


def _whole(key: str, value: Any) -> int:
    is_whole = isinstance(value, int) or (isinstance(value, float) and value.is_integer())
    if not is_whole or isinstance(value, bool) or not 0 <= value <= _UINT32:
        found = shown(value)
        raise BridgeError(f"{key}: expected a whole number from 0 to {_UINT32}, found {found}")
    return int(value)


def require_type(topic: str, expected: Optional[str], message: Any) -> None:
    """Raises a BridgeError if a topic has another type than a message.

    Args:
        topic: absolute name of the topic, such as "/robot1/scan".
        expected: the topic's type; None if it is not known.
        message: the message that is to be published.
    """
    if expected not in (None, message._type):
        raise BridgeError(f'the topic "{topic}" expects {expected}, found {message._type}')

"""Messages as dicts of plain values, for JSON and CBOR, as the rosbridge protocol has them.

A time is {"secs", "nsecs"}. Of arrays, JSON has lists, and base64 text for bytes; CBOR has typed
arrays (RFC 8746), and bytes. JSON has no NaN or infinity: they are null.
"""

import base64
import binascii
from functools import lru_cache
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from flatland_server.exceptions import MessageError, shortened, suggestion
from flatland_server.messages.definition import FieldType
from flatland_server.messages.message_types import TYPES, get

_BYTES = ("uint8", "char")
_FLOATS = ("float32", "float64")
_TAGS = {
    **{"uint16": (69, "<u2"), "uint32": (70, "<u4"), "uint64": (71, "<u8"), "byte": (72, "i1")},
    **{"int8": (72, "i1"), "int16": (77, "<i2"), "int32": (78, "<i4"), "int64": (79, "<i8")},
    **{"float32": (85, "<f4"), "float64": (86, "<f8")},
}
"""The CBOR tags of typed arrays, little-endian, and NumPy's names of their numbers."""
_TYPE_OF_TAG = dict(_TAGS.values())

Convert = Callable[[Any], Any]


class Form(NamedTuple):
    """The fields of a message type, with their conversions."""

    type_name: str
    fields: Dict[str, Tuple[Convert, Convert]]  # to plain values, and from them


def to_plain(message: Any, *, cbor: bool = False) -> Dict[str, Any]:
    """A message as a dict.

    Args:
        message: the message.
        cbor: whether arrays of numbers are tagged bytes; otherwise they are NumPy's, or lists.
    """
    kind: Any = type(message)
    fields = form_of(kind, cbor).fields
    return {name: write(getattr(message, name)) for name, (write, _) in fields.items()}


def from_plain(message_type: Any, value: Any) -> Any:
    """A message with the given fields; the others have their defaults.

    Args:
        message_type: its class.
        value: a dict of fields, or a list of all of them in their order.

    Raises:
        MessageError: there is no such field, or a value has another type.
    """
    form = form_of(message_type, False)
    if isinstance(value, (list, tuple)):
        if len(value) > len(form.fields):
            count = len(form.fields)
            raise MessageError(f"{form.type_name}: expected {count} fields, found {len(value)}")
        value = dict(zip(form.fields, value))
    if not isinstance(value, dict):
        raise MessageError(f"{form.type_name}: expected its fields, found {shortened(repr(value))}")
    message = message_type()
    for name, given in value.items():
        if name not in form.fields:
            hint = suggestion(str(name), form.fields)
            raise MessageError(f'{form.type_name} has no field "{shortened(str(name))}"{hint}')
        try:
            setattr(message, name, form.fields[name][1](given))
        except MessageError as error:
            raise MessageError(f"{name}: {error}") from None
        except (ArithmeticError, TypeError, ValueError, binascii.Error):
            kind = message_type._slot_types[message_type.__slots__.index(name)]
            found = shortened(repr(given))
            raise MessageError(
                f"{form.type_name}: {name}: expected {kind}, found {found}"
            ) from None
    return message


@lru_cache(maxsize=None)
def form_of(message_type: Any, cbor: bool) -> Form:
    """The fields of a message type and how they are converted.

    Args:
        message_type: its class.
        cbor: as for `to_plain`.
    """
    fields = zip(message_type.__slots__, message_type._slot_types)
    return Form(
        message_type._type, {name: _conversions(parse_type(kind), cbor) for name, kind in fields}
    )


def parse_type(kind: str) -> FieldType:
    """The parts of a field's type, such as "float32[]" or "float64[36]"."""
    base, bracket, length = kind.partition("[")
    base = "std_msgs/Header" if base == "Header" else base
    size = length.rstrip("]")
    return FieldType(base, bool(bracket), int(size) if size else None)


def _conversions(kind: FieldType, cbor: bool) -> Tuple[Convert, Convert]:
    if not kind.is_array:
        return _item_conversions(kind.base, cbor)
    if kind.base in _BYTES:
        return (bytes if cbor else _to_base64), _of_length(_to_bytes, kind.length)
    write_item, read_item = _item_conversions(kind.base, cbor)

    def read(value: Any) -> List[Any]:
        if isinstance(value, np.ndarray):
            value = value.tolist()
        if not isinstance(value, (list, tuple)):
            raise TypeError
        return [read_item(item) for item in value]

    if kind.base not in _TAGS:
        return (lambda values: [write_item(each) for each in values]), _of_length(read, kind.length)
    tag, dtype = _TAGS[kind.base]
    if cbor:
        return _typed_array(tag, dtype), _of_length(read, kind.length)
    if kind.base in _FLOATS:  # of which JSON's text has no more digits than they have
        return (lambda values: np.ascontiguousarray(values, dtype)), _of_length(read, kind.length)
    return (lambda values: [int(each) for each in values]), _of_length(read, kind.length)


def _item_conversions(base: str, cbor: bool) -> Tuple[Convert, Convert]:
    if base in ("time", "duration"):
        return _time_to_plain, _time_reader(TYPES.Time if base == "time" else TYPES.Duration)
    if base == "string":
        return str, _to_string
    if base == "bool":
        return bool, _to_bool
    if base in _FLOATS:
        return float, _to_float
    if "/" not in base:
        return int, _to_int
    nested = get(base)
    return (lambda message: to_plain(message, cbor=cbor)), (lambda v: from_plain(nested, v))


def _of_length(read: Convert, length: Optional[int]) -> Convert:
    if length is None:
        return read

    def read_exactly(value: Any) -> Any:
        values = read(value)
        if len(values) != length:
            raise ValueError
        return values

    return read_exactly


def _typed_array(tag: int, dtype: str) -> Convert:
    import cbor2

    return lambda values: cbor2.CBORTag(tag, np.ascontiguousarray(values, dtype).tobytes())


def read_tag(decoder: Any, tag: Any) -> Any:
    """The array of a CBOR tag; a `tag_hook` of cbor2."""
    if tag.tag in _TYPE_OF_TAG and isinstance(tag.value, bytes):
        return np.frombuffer(tag.value, _TYPE_OF_TAG[tag.tag])
    return tag.value


def _time_to_plain(time: Any) -> Dict[str, int]:
    return {"secs": time.secs, "nsecs": time.nsecs}


def _time_reader(make: Callable[..., Any]) -> Convert:
    def read(value: Any) -> Any:
        if not isinstance(value, dict):
            raise TypeError
        seconds = value.get("secs", value.get("sec", 0))
        nanoseconds = value.get("nsecs", value.get("nanosec", value.get("nsec", 0)))
        return make(_to_int(seconds), _to_int(nanoseconds))

    return read


def _to_base64(value: Any) -> str:
    return base64.b64encode(bytes(value)).decode()


def _to_bytes(value: Any) -> bytes:
    return base64.b64decode(value, validate=True) if isinstance(value, str) else bytes(value)


def _to_string(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError
    return value


def _to_bool(value: Any) -> bool:
    if value not in (True, False, 0, 1):
        raise TypeError
    return bool(value)


def _to_float(value: Any) -> float:
    if value is None:
        return float("nan")
    if isinstance(value, (str, bytes)):
        raise TypeError
    return float(value)


def _to_int(value: Any) -> int:
    if isinstance(value, (str, bytes)) or value != int(value):
        raise TypeError
    return int(value)

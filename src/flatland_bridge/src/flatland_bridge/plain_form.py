"""Messages as dicts of plain values, for JSON and CBOR, as the rosbridge protocol has them.

A time is {"secs", "nsecs"}. Of arrays, JSON has lists, and base64 text for bytes; CBOR has typed
arrays (RFC 8746), and bytes. JSON has no NaN or infinity: they are null.
"""

import base64
import math
import reprlib
import struct
from contextlib import suppress
from functools import lru_cache
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from flatland_server.exceptions import MessageError, shortened, suggestion
from flatland_server.messages import (
    INTEGERS,
    NUMBERS,
    TYPES,
    FieldType,
    ObjectBudget,
    get,
    objects_in,
)

_BYTES = ("uint8", "char")
_FLOATS = ("float32", "float64")
_TIMES = ("time", "duration")
_TAGS = {
    **{"uint16": (69, "<u2"), "uint32": (70, "<u4"), "uint64": (71, "<u8"), "byte": (72, "i1")},
    **{"int8": (72, "i1"), "int16": (77, "<i2"), "int32": (78, "<i4"), "int64": (79, "<i8")},
    **{"float32": (85, "<f4"), "float64": (86, "<f8")},
}
"""The CBOR tags of typed arrays, little-endian, and NumPy's names of their numbers."""
TYPED_ARRAYS = {64: "u1", 68: "u1", **dict(_TAGS.values())}
"""NumPy's names of the numbers in typed arrays, by their tags."""

Write = Callable[[Any], Any]
Read = Callable[[Any, ObjectBudget], Any]


_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = 80


def shown(value: object) -> str:
    """A value for an error, however large it is."""
    return shortened(_REPR.repr(value))


class _WrongValueError(ValueError):
    """A value is not one of its field's type.

    Args:
        expected: type of the field, with its range.
        found: value in the message.
    """

    def __init__(self, expected: object, found: object) -> None:
        super().__init__(f"expected {expected}, found {shown(found)}")


class Form(NamedTuple):
    """The fields of a message type, with their conversions."""

    type_name: str
    fields: Dict[str, Tuple[Write, Read]]  # to plain values, and from them


def to_plain(message: Any, *, cbor: bool = False) -> Dict[str, Any]:
    """A message as a dict.

    Args:
        message: the message.
        cbor: whether arrays of numbers are tagged bytes; otherwise they are NumPy's, or lists.
    """
    kind: Any = type(message)
    fields = form_of(kind, cbor).fields
    return {name: write(getattr(message, name)) for name, (write, _) in fields.items()}


def from_plain(message_type: Any, value: Any, budget: Optional[ObjectBudget] = None) -> Any:
    """A message with the given fields; the others have their defaults.

    Args:
        message_type: class of the message.
        value: a dict of fields, or a list of all of them in their order.
        budget: limits the number of messages within this one.

    Raises:
        MessageError: there is no such field, or a value is not one of its type.
    """
    form = form_of(message_type, False)
    budget = budget or ObjectBudget()
    if isinstance(value, (list, tuple)):
        if len(value) > len(form.fields):
            count = len(form.fields)
            raise MessageError(f"{form.type_name}: expected {count} fields, found {len(value)}")
        value = dict(zip(form.fields, value))
    if not isinstance(value, dict):
        raise MessageError(f"{form.type_name}: expected its fields, found {shown(value)}")
    message = message_type()
    for name, given in value.items():
        if name not in form.fields:
            hint = suggestion(str(name), form.fields)
            raise MessageError(f'{form.type_name} has no field "{shortened(str(name))}"{hint}')
        try:
            setattr(message, name, form.fields[name][1](given, budget))
        except MessageError as error:
            raise MessageError(f"{name}: {error}") from None
        except _WrongValueError as error:
            raise MessageError(f"{form.type_name}: {name}: {error}") from None
    return message


@lru_cache(maxsize=None)
def form_of(message_type: Any, cbor: bool) -> Form:
    """The fields of a message type and how they are converted.

    Args:
        message_type: class of the messages.
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


def _conversions(kind: FieldType, cbor: bool) -> Tuple[Write, Read]:
    if not kind.is_array:
        return _item_conversions(kind.base, cbor)
    if kind.base in _BYTES:
        return (bytes if cbor else _to_base64), _of_length(_bytes_reader(kind), kind)
    write_item, read_item = _item_conversions(kind.base, cbor)
    objects = objects_in(get(kind.base)()) if "/" in kind.base else kind.base in _TIMES
    letter = NUMBERS[kind.base] if kind.base in _TAGS else None

    def read(value: Any, budget: ObjectBudget) -> List[Any]:
        if isinstance(value, np.ndarray):
            value = value.tolist()
        if not isinstance(value, (list, tuple)):
            raise _WrongValueError(kind, value)
        budget.take(len(value) * objects)
        if letter is not None:
            with suppress(struct.error, OverflowError):  # in C, if all are numbers in their range
                struct.pack(f"<{len(value)}{letter}", *value)
                return list(value)
        return [read_item(item, budget) for item in value]

    if kind.base not in _TAGS:
        return (lambda values: [write_item(each) for each in values]), _of_length(read, kind)
    tag, dtype = _TAGS[kind.base]
    if cbor:
        return _typed_array(tag, dtype), _of_length(read, kind)
    if kind.base in _FLOATS:  # of which JSON's text has no more digits than they have
        return (lambda values: np.ascontiguousarray(values, dtype)), _of_length(read, kind)
    return (lambda values: [int(each) for each in values]), _of_length(read, kind)


def _item_conversions(base: str, cbor: bool) -> Tuple[Write, Read]:
    if base in _TIMES:
        return _time_to_plain, _time_reader(base)
    if base == "string":
        return plain_text, _to_string
    if base == "bool":
        return bool, _to_bool
    if base in _FLOATS:
        return float, _float_reader(base)
    if base in INTEGERS:
        return int, _integer_reader(base, *INTEGERS[base])
    nested = get(base)
    return (
        lambda message: to_plain(message, cbor=cbor),
        lambda value, budget: from_plain(nested, value, budget),
    )


def _of_length(read: Read, kind: FieldType) -> Read:
    if kind.length is None:
        return read

    def read_exactly(value: Any, budget: ObjectBudget) -> Any:
        values = read(value, budget)
        if len(values) != kind.length:
            raise _WrongValueError(kind, value)
        return values

    return read_exactly


def _typed_array(tag: int, dtype: str) -> Write:
    import cbor2

    return lambda values: cbor2.CBORTag(tag, np.ascontiguousarray(values, dtype).tobytes())


def _time_to_plain(time: Any) -> Dict[str, int]:
    return {"secs": time.secs, "nsecs": time.nsecs}


def plain_text(text: str) -> str:
    """A string without the surrogates that stand for bytes that are not UTF-8."""
    return text if text.isascii() else text.encode("utf-8", "replace").decode()


def _to_base64(value: Any) -> str:
    return base64.b64encode(bytes(value)).decode()


def _time_reader(base: str) -> Read:
    make = TYPES.Time if base == "time" else TYPES.Duration
    low, high = INTEGERS["uint32" if base == "time" else "int32"]
    to_integer = _integer_reader("int64", *INTEGERS["int64"])
    expected = f"{base} (secs from {low} to {high})"

    def read(value: Any, budget: ObjectBudget) -> Any:
        if not isinstance(value, dict):
            raise _WrongValueError(expected, value)
        seconds = value.get("secs", value.get("sec", 0))
        nanoseconds = value.get("nsecs", value.get("nanosec", value.get("nsec", 0)))
        try:
            time = make(to_integer(seconds, budget), to_integer(nanoseconds, budget))
        except TypeError:  # a time before 0
            raise _WrongValueError(expected, value) from None
        if not low <= time.secs <= high:
            raise _WrongValueError(expected, value)
        return time

    return read


def _bytes_reader(kind: FieldType) -> Read:
    def read(value: Any, budget: ObjectBudget) -> bytes:
        try:
            if isinstance(value, str):
                return base64.b64decode(value, validate=True)
            if isinstance(value, (bytes, list, tuple)):
                return bytes(value)
            if isinstance(value, np.ndarray):
                return bytes(value.tolist())
        except (TypeError, ValueError):
            pass
        raise _WrongValueError(f"{kind} ({low} to {high})", value)

    low, high = INTEGERS[kind.base]
    return read


def _to_string(value: Any, budget: ObjectBudget) -> str:
    if not isinstance(value, str):
        raise _WrongValueError("string", value)
    if plain_text(value) != value:
        raise _WrongValueError("string of UTF-8", value)
    return value


def _to_bool(value: Any, budget: ObjectBudget) -> bool:
    if not isinstance(value, (int, float)) or value not in (0, 1):
        raise _WrongValueError("bool", value)
    return bool(value)


def _float_reader(base: str) -> Read:
    largest = float(np.finfo(base).max)

    def read(value: Any, budget: ObjectBudget) -> float:
        if type(value) is float and -largest <= value <= largest:
            return value
        if value is None:
            return math.nan
        if not isinstance(value, (int, float)):
            raise _WrongValueError(base, value)
        if not -largest <= value <= largest and value == value and abs(value) != math.inf:
            raise _WrongValueError(f"{base} (up to {largest:g})", value)
        return float(value)

    return read


def _integer_reader(base: str, low: int, high: int) -> Read:
    def read(value: Any, budget: ObjectBudget) -> int:
        is_whole = isinstance(value, int) or (isinstance(value, float) and value.is_integer())
        if not is_whole or not low <= value <= high:
            raise _WrongValueError(f"{base} ({low} to {high})", value)
        return int(value)

    return read

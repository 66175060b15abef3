"""Plain data as bytes and back: the format of saved states.

JSON, with three additions, each an object with a single key: `{"$bytes": base64}`, `{"$array":
[dtype, shape, base64]}` for a numpy array of numbers, and `{"$dict": [[key, value] ...]}` for a
dict with integers as keys. Numbers come back bit for bit; tuples come back as lists.
Unlike pickle, reading a file from elsewhere runs no code of that file.
"""

import base64
import json
import math
from dataclasses import fields
from functools import lru_cache
from typing import Any, Dict, List, Optional, Tuple, Type, TypeVar, Union, get_type_hints

import numpy as np

T = TypeVar("T")

_INTEGERS = range(-(2**63), 2**63)

_PLAIN = frozenset((bool, int, float, str, type(None)))
_NUMBERS = "biufc"
"""The kinds of dtypes of arrays: booleans, integers, floating-point and complex numbers."""


def dumps(data: Any) -> bytes:
    """Serializes plain data.

    Raises:
        TypeError: a part of it is not plain data; says which.
    """
    return json.dumps(_encode(data), separators=(",", ":")).encode()


def loads(data: bytes) -> Any:
    """The value given to `dumps`.

    Raises:
        ValueError: this is not the result of `dumps`.
    """
    try:
        return json.loads(data, object_hook=_decode)
    except (KeyError, TypeError, RecursionError) as error:
        raise ValueError(f"not plain data: {error}") from None


def made(cls: Type[T], content: Any, where: str) -> T:
    """A dataclass out of plain data, if its values have the types of the attributes.

    Args:
        cls: the dataclass, of numbers, strings, bytes, lists, dicts with names, or None.
        content: a dict of the attributes.
        where: its place in the data, for the error.

    Raises:
        ValueError: an attribute is missing, unknown or of another type, a number is not finite, or
            an integer has more than 64 bits.
    """
    kinds = _kinds(cls)  # type: ignore[arg-type] # a class is hashable
    if not isinstance(content, dict) or content.keys() != kinds.keys():
        raise ValueError(f"{where}: expected {', '.join(kinds)}")
    for name, kind in kinds.items():
        if not _is_of(content[name], kind):
            raise ValueError(f"{where}.{name}: expected another value, found {content[name]!r:.60}")
    return cls(**content)


@lru_cache(maxsize=None)
def _kinds(cls: Type[Any]) -> Dict[str, Any]:
    """The types of a dataclass's attributes."""
    hints = get_type_hints(cls)
    return {each.name: hints[each.name] for each in fields(cls)}


def _is_of(value: Any, kind: Any) -> bool:
    """True if a value has a type: a class, Any, Optional[...], List[...] or Dict[str, ...]."""
    origin = getattr(kind, "__origin__", None)
    parts: Tuple[Any, ...] = getattr(kind, "__args__", ())
    if kind is Any:
        return True
    if origin is Union:
        return any(_is_of(value, part) for part in parts)
    if origin is list:
        return isinstance(value, list) and all(_is_of(each, parts[0]) for each in value)
    if origin is dict:
        return isinstance(value, dict) and all(
            isinstance(key, str) and _is_of(each, parts[1]) for key, each in value.items()
        )
    if kind in (int, float):
        is_number = isinstance(value, (int, kind)) and not isinstance(value, bool)
        return is_number and (
            value in _INTEGERS if isinstance(value, int) else math.isfinite(value)
        )
    return isinstance(value, kind)


def _encode(value: Any, place: "_Place" = None) -> Any:
    if type(value) in _PLAIN:
        return value
    if isinstance(value, (int, float, str)):
        # Subclasses, as of enumerations or numpy's numbers, become what they are derived from.
        return next(kind(value) for kind in (int, float, str) if isinstance(value, kind))
    if isinstance(value, np.generic) and value.dtype.kind in _NUMBERS:
        return _encode(value.item(), place) if value.dtype.kind in "biuf" else _array(value)
    if isinstance(value, np.ndarray) and value.dtype.kind in _NUMBERS:
        return _array(value)
    if isinstance(value, (bytes, bytearray)):
        return {"$bytes": _to_text(bytes(value))}
    if isinstance(value, (list, tuple)):
        return [_encode(item, (place, index)) for index, item in enumerate(value)]
    if isinstance(value, dict):
        return _encode_dict(value, place)
    raise TypeError(
        f"{_shown(place)}: expected numbers, strings, bytes, arrays of numbers, lists and dicts, "
        f"found a {type(value).__name__}"
    )


def _encode_dict(value: Dict[Any, Any], place: "_Place") -> Dict[str, Any]:
    items = {key: _encode(item, (place, key)) for key, item in value.items()}
    if all(isinstance(key, str) and not key.startswith("$") for key in items):
        return items
    for key in items:
        if not isinstance(key, (str, int)):
            raise TypeError(
                f"{_shown(place)}: expected keys that are strings or integers, found {key!r}"
            )
    return {"$dict": list(map(list, items.items()))}


_Place = Optional[Tuple[Any, Any]]
"""The place of a container, and an index or a key in it; None for the whole."""


def _shown(place: _Place) -> str:
    return "data" if place is None else f"{_shown(place[0])}[{place[1]!r}]"


def _array(value: Any) -> Dict[str, Any]:
    array = np.asarray(value)
    little_endian = array.astype(array.dtype.newbyteorder("<"), copy=False)
    return {
        "$array": [
            little_endian.dtype.str,
            list(array.shape),
            _to_text(np.ascontiguousarray(little_endian).tobytes()),
        ]
    }


def _decode(value: Dict[str, Any]) -> Any:
    if len(value) == 1:
        [(key, content)] = value.items()
        if key == "$bytes":
            return _to_bytes(content)
        if key == "$array":
            return _to_array(content)
        if key == "$dict":
            return dict(content)
    return value


def _to_array(content: List[Any]) -> Any:
    name, shape, data = content
    dtype = np.dtype(name)
    if dtype.kind not in _NUMBERS:
        raise ValueError(f"expected an array of numbers, found one of {dtype}")
    return np.frombuffer(_to_bytes(data), dtype).reshape(shape).astype(dtype.newbyteorder("="))


def _to_text(data: bytes) -> str:
    return base64.b64encode(data).decode()


def _to_bytes(text: str) -> bytes:
    return base64.b64decode(text, validate=True)

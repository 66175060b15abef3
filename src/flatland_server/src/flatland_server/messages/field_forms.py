"""Serialization of message fields.

Consecutive numbers are packed together, also those of nested messages: the pose of an Odometry is
one `struct.pack` of seven numbers.
"""

import struct
from abc import abstractmethod
from functools import cached_property
from itertools import groupby
from operator import attrgetter
from typing import Any, Callable, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from flatland_server.exceptions import shortened
from flatland_server.messages.definition import NUMBERS, Definition, FieldType
from flatland_server.messages.wire_form import (
    LENGTH,
    WRONG_VALUE,
    Part,
    Reader,
    WireForm,
    objects_in,
    with_owner,
)

_TIMES = {"time": "I", "duration": "i"}
_BYTES = ("uint8", "char")
"""The types of items for which arrays are `bytes`."""

Definitions = Callable[[str], Definition]
"""The definition of a message type, by its name."""
Types = Callable[[str], "WireForm"]
"""The wire form of a message type, by its name."""
Factory = Callable[[str], Callable[[], Any]]
"""Returns the constructor of a time, a duration or a message, by the name of the type."""


class _Field(NamedTuple):
    """A field of a message or of a message nested in it: "pose.position.x"."""

    path: str
    type: FieldType


def wire_form(
    definition: Definition, definition_of: Definitions, types: Types, factory: Factory
) -> WireForm:
    """The wire form of a type.

    Args:
        definition: the type's definition.
        definition_of: the definitions of the types that it uses.
        types: wire forms of these types, for arrays of them.
        factory: makes the items of arrays.
    """
    parts: List[Part] = []
    numbers: List[Tuple[str, str]] = []
    for path, kind in _flat(definition, definition_of, ""):
        if kind.base in NUMBERS and not kind.is_array:
            numbers.append((path, kind.base))
        elif kind.base in _TIMES and not kind.is_array:
            numbers += [(f"{path}.secs", _TIMES[kind.base]), (f"{path}.nsecs", _TIMES[kind.base])]
        else:
            if numbers:
                parts.append(_Numbers(numbers))
                numbers = []
            parts.append(_part(path, kind, types, factory))
    if numbers:
        parts.append(_Numbers(numbers))
    return WireForm(parts)


def _flat(definition: Definition, definition_of: Definitions, prefix: str) -> List[_Field]:
    """The fields of a message and of those nested in it."""
    fields: List[_Field] = []
    for name, kind in definition.fields:
        if kind.is_array or kind.base in NUMBERS or kind.base in ("string", *_TIMES):
            fields.append(_Field(prefix + name, kind))
        else:
            fields += _flat(definition_of(kind.base), definition_of, f"{prefix}{name}.")
    return fields


def _part(path: str, kind: FieldType, types: Types, factory: Factory) -> Part:
    if not kind.is_array:
        return _String(path)
    if kind.base in _BYTES:
        return _Bytes(path, kind)
    if kind.base in NUMBERS:
        return _NumberArray(path, kind)
    if kind.base == "string":
        return _StringArray(path, kind)
    if kind.base in _TIMES:
        form = WireForm([_Numbers([("secs", _TIMES[kind.base]), ("nsecs", _TIMES[kind.base])])])
        return _MessageArray(path, kind, lambda: form, factory)
    return _MessageArray(path, kind, lambda: types(kind.base), factory)


class _Numbers(Part):
    """Numbers one after another.

    Args:
        fields: the path of each, and its type or its format in the module struct.
    """

    def __init__(self, fields: Sequence[Tuple[str, str]]) -> None:
        self._fields = fields
        formats = [NUMBERS.get(kind, kind) for _, kind in fields]
        self._form = struct.Struct("<" + "".join(formats))
        paths = [path for path, _ in fields]
        get = attrgetter(*paths)
        self._get: Callable[[Any], Sequence[Any]] = get if len(paths) > 1 else lambda m: (get(m),)
        split = [path.rpartition(".") for path in paths]
        self._names = [
            (attrgetter(owner) if owner else None, [name for _, _, name in group])
            for owner, group in groupby(split, lambda parts: parts[0])
        ]

    @property
    def least_size(self) -> int:
        return self._form.size

    def write(self, message: Any, chunks: List[bytes]) -> None:
        chunks.append(self._form.pack(*self._get(message)))

    def read(self, message: Any, reader: Reader) -> None:
        values = iter(reader.numbers(self._form))
        for owner_of, names in self._names:
            owner = message if owner_of is None else owner_of(message)
            for name, value in zip(names, values):
                setattr(owner, name, value)

    def problem(self, message: Any) -> Optional[str]:
        for path, kind in self._fields:
            try:
                struct.pack("<" + NUMBERS.get(kind, kind), attrgetter(path)(message))
            except WRONG_VALUE:
                return _expected(message, path, {"I": "uint32", "i": "int32"}.get(kind, kind))
        return None


class _Single(Part):
    """A part that is one field."""

    item_size = 1
    """Least number of bytes of an item."""

    def __init__(self, path: str, kind: FieldType) -> None:
        self._path = path
        self._kind = kind
        self._get = attrgetter(path)
        owner, _, self._name = path.rpartition(".")
        self._owner = attrgetter(owner) if owner else None

    @property
    def least_size(self) -> int:
        fixed = self._kind.length
        return LENGTH.size if fixed is None else fixed * self.item_size

    def read(self, message: Any, reader: Reader) -> None:
        owner = message if self._owner is None else self._owner(message)
        setattr(owner, self._name, self.read_value(reader))

    @abstractmethod
    def read_value(self, reader: Reader) -> Any:
        """The field's value."""

    def problem(self, message: Any) -> Optional[str]:
        try:
            self.write(message, [])
        except WRONG_VALUE:
            return _expected(message, self._path, str(self._kind))
        return None

    def _write_length(self, length: int, chunks: List[bytes]) -> None:
        fixed = self._kind.length
        if fixed is None:
            chunks.append(LENGTH.pack(length))
        elif length != fixed:
            raise ValueError(f"expected {fixed} items, found {length}")

    def _read_length(self, reader: Reader) -> int:
        return reader.length(self.item_size, self._kind.length)


class _String(_Single):
    def __init__(self, path: str) -> None:
        super().__init__(path, FieldType("string"))

    def write(self, message: Any, chunks: List[bytes]) -> None:
        _write_string(self._get(message), chunks)

    def read_value(self, reader: Reader) -> str:
        return reader.string()


class _StringArray(_Single):
    item_size = LENGTH.size

    def write(self, message: Any, chunks: List[bytes]) -> None:
        strings = self._get(message)
        self._write_length(len(strings), chunks)
        for string in strings:
            _write_string(string, chunks)

    def read_value(self, reader: Reader) -> List[str]:
        return [reader.string() for _ in range(self._read_length(reader))]


class _Bytes(_Single):
    """An array of uint8."""

    def write(self, message: Any, chunks: List[bytes]) -> None:
        value = self._get(message)
        if isinstance(value, np.ndarray):
            value = value.astype(np.uint8, casting="safe", copy=False).tobytes()
        self._write_length(len(value), chunks)  # an int, which `bytes` would take, has no len
        chunks.append(bytes(value))

    def read_value(self, reader: Reader) -> bytes:
        return reader.bytes(self._read_length(reader))


class _NumberArray(_Single):
    def __init__(self, path: str, kind: FieldType) -> None:
        super().__init__(path, kind)
        self._format = NUMBERS[kind.base]
        self._type = np.dtype("<" + self._format)
        self.item_size = self._type.itemsize

    def write(self, message: Any, chunks: List[bytes]) -> None:
        values = self._get(message)
        self._write_length(len(values), chunks)
        if isinstance(values, np.ndarray) and np.can_cast(values.dtype, self._type, "same_kind"):
            chunks.append(values.reshape(len(values)).astype(self._type, copy=False).tobytes())
        else:
            chunks.append(struct.pack(f"<{len(values)}{self._format}", *values))

    def read_value(self, reader: Reader) -> Tuple[Any, ...]:
        length = self._read_length(reader)
        data = reader.bytes(length * self.item_size)
        return struct.unpack(f"<{length}{self._format}", data)


class _MessageArray(_Single):
    """An array of messages, times or durations."""

    def __init__(
        self, path: str, kind: FieldType, form: Callable[[], WireForm], factory: Factory
    ) -> None:
        super().__init__(path, kind)
        self._form = form
        self._factory = factory

    @property
    def item_size(self) -> int:  # type: ignore[override]
        return self._form().least_size

    @cached_property
    def _objects(self) -> int:
        """The objects that an item is made of."""
        return objects_in(self._factory(self._kind.base)())

    def write(self, message: Any, chunks: List[bytes]) -> None:
        items = self._get(message)
        self._write_length(len(items), chunks)
        write = self._form().write
        for item in items:
            write(item, chunks)

    def read_value(self, reader: Reader) -> List[Any]:
        length = self._read_length(reader)
        reader.budget.take(length * self._objects)
        make, read = self._factory(self._kind.base), self._form().read
        items = [make() for _ in range(length)]
        for item in items:
            read(item, reader)
        return items

    def problem(self, message: Any) -> Optional[str]:
        problem = super().problem(message)
        if problem is None:
            return None
        try:
            items = self._get(message)
        except AttributeError:
            return problem
        for index, item in enumerate(items if isinstance(items, (list, tuple)) else ()):
            try:
                self._form().write(item, [])
            except WRONG_VALUE:
                return with_owner(f"{self._path}[{index}]", self._form().problem(item))
        return problem


def _write_string(string: str, chunks: List[bytes]) -> None:
    data = string.encode("utf-8", "surrogateescape")
    chunks.append(LENGTH.pack(len(data)))
    chunks.append(data)


def _expected(message: Any, path: str, kind: str) -> str:
    """The problem of a field of a message, or of the object that it belongs to."""
    value, names = message, path.split(".")
    for depth, name in enumerate(names):
        if not hasattr(value, name):
            owner = ".".join(names[:depth])
            return f'{owner}: expected an object with "{name}", found {shortened(repr(value))}'
        value = getattr(value, name)
    return f"{path}: expected {kind}, found {shortened(repr(value))}"

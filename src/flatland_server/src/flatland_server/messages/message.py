"""Message classes of our own, made from definitions, with the interface of ROS's generated ones."""

import dataclasses
import inspect
from functools import partial
from typing import Any, Callable, ClassVar, Dict, List, Tuple, Type

import numpy as np

from flatland_server.exceptions import MessageError, listed, suggestion
from flatland_server.messages.definition import NUMBERS, Definition, FieldType
from flatland_server.messages.field_forms import Factory
from flatland_server.messages.wire_form import WRONG_VALUE, Reader, WireForm, with_owner


class Message:
    """The base of message classes; each is a dataclass with the fields of its definition.

    All fields are given, or some of them by keyword. The others have ROS's defaults: 0, "", False,
    an empty list, nested messages with their defaults.

    Raises:
        MessageError: there is no such field, or not all are given without keywords.
    """

    __slots__ = ()
    _type: ClassVar[str] = ""
    _md5sum: ClassVar[str] = ""
    _full_text: ClassVar[str] = ""
    _has_header: ClassVar[bool] = False
    _slot_types: ClassVar[List[str]] = []
    _fields: ClassVar[Tuple[Tuple[str, Callable[[], Any]], ...]] = ()
    _wire_form: ClassVar[WireForm]

    def __init__(self, *args: Any, **fields: Any) -> None:
        if args:
            self._check_arguments(args, fields)
            fields = {name: value for (name, _), value in zip(self._fields, args)}
        if not fields:
            for name, make_default in self._fields:
                setattr(self, name, make_default())
            return
        for name, make_default in self._fields:
            value = fields.pop(name, None)
            setattr(self, name, make_default() if value is None else value)
        if fields:
            self._check_fields(fields)

    def serialize(self, buff: Any) -> None:
        """Writes the message into a binary file or buffer.

        Raises:
            MessageError: a field has a value of another type.
        """
        chunks: List[bytes] = []
        try:
            self._wire_form.write(self, chunks)
        except WRONG_VALUE:
            raise MessageError(with_owner(self._type, self._wire_form.problem(self))) from None
        buff.write(b"".join(chunks))

    def deserialize(self, data: bytes) -> "Message":
        """Sets all fields to those of a serialized message, and returns this one.

        Raises:
            MessageError: the data is too short.
        """
        self._wire_form.read(self, Reader(data))
        return self

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Message) or self._type != other._type:
            return NotImplemented
        return all(_are_equal(getattr(self, f), getattr(other, f)) for f, _ in self._fields)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={getattr(self, name)!r}" for name, _ in self._fields)
        return f"{self._type.partition('/')[2]}({fields})"

    def _get_types(self) -> List[str]:
        return self._slot_types

    @classmethod
    def _check_arguments(cls, args: Tuple[Any, ...], fields: Dict[str, Any]) -> None:
        if fields or len(args) != len(cls._fields):
            names = listed([name for name, _ in cls._fields])
            raise MessageError(
                f"{cls._type}: expected all fields ({names}), or some of them by keyword, "
                f"found {len(args)}{' and keywords' if fields else ''}"
            )

    @classmethod
    def _check_fields(cls, fields: Dict[str, Any]) -> None:
        names = [name for name, _ in cls._fields]
        for name in fields:
            raise MessageError(
                f'{cls._type} has no field "{name}"{suggestion(name, names)}; '
                f"its fields are: {listed(names)}"
            )


def make_class(
    definition: Definition,
    bases: Tuple[type, ...],
    factory: Factory,
    wire_form: WireForm,
    restore: Callable[..., Any],
    **attributes: Any,
) -> Type[Message]:
    """The class of a message type.

    Args:
        definition: the type's definition.
        bases: base classes, first `Message`.
        factory: makes nested messages and times, by the name of their type.
        wire_form: the type's wire form.
        restore: makes a pickled message again, from the name of its type and its values.
        attributes: further attributes of the class.
    """
    names = tuple(name for name, _ in definition.fields)

    def reduce(self: Message) -> Tuple[Any, ...]:
        return restore, (definition.name, *(getattr(self, name) for name in names))

    cls = type(
        definition.name.partition("/")[2],
        bases,
        {
            "__doc__": f"A {definition.name}.",
            "__module__": f"{definition.name.partition('/')[0]}.msg",
            "__annotations__": {name: _python_type(kind) for name, kind in definition.fields},
            "__slots__": names,
            "__reduce__": reduce,
            "__signature__": _signature(names),
            "_type": definition.name,
            "_fields": tuple((name, _default(kind, factory)) for name, kind in definition.fields),
            "_has_header": definition.fields[:1] == (("header", FieldType("std_msgs/Header")),),
            "_slot_types": [str(kind) for _, kind in definition.fields],
            "_wire_form": wire_form,
            **{constant.name: constant.value for constant in definition.constants},
            **attributes,
        },
    )
    return dataclasses.dataclass(init=False, repr=False, eq=False)(cls)


def _signature(names: Tuple[str, ...]) -> inspect.Signature:
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    return inspect.Signature([inspect.Parameter(name, kind, default=None) for name in names])


def _python_type(kind: FieldType) -> Any:
    if kind.is_array:
        return bytes if kind.base in ("uint8", "char") else List[Any]
    if kind.base in NUMBERS:
        return {"bool": bool, "float32": float, "float64": float}.get(kind.base, int)
    return str if kind.base == "string" else Any


def _default(kind: FieldType, factory: Factory) -> Callable[[], Any]:
    """The constructor of a field's default value."""
    if kind.is_array:
        return _default_array(kind, factory)
    if kind.base in NUMBERS or kind.base == "string":
        return {"string": str, "bool": bool, "float32": float, "float64": float}.get(kind.base, int)
    return factory(kind.base)


def _default_array(kind: FieldType, factory: Factory) -> Callable[[], Any]:
    length = kind.length or 0
    if kind.base in ("uint8", "char"):
        return partial(bytes, length)
    make_item = _default(FieldType(kind.base), factory)
    if not length:
        return list
    return lambda: [make_item() for _ in range(length)]


def _are_equal(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.array_equal(a, b)
    if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
        return len(a) == len(b) and all(map(_are_equal, a, b))
    return bool(a == b)

"""Message definitions in ROS's .msg grammar: fields, constants, and the MD5 sum of a type.

https://wiki.ros.org/msg describes the grammar,
https://wiki.ros.org/ROS/Technical%20Overview the sum.
"""

import hashlib
import re
import struct
from dataclasses import dataclass
from keyword import iskeyword
from typing import Callable, Iterable, Iterator, List, NamedTuple, Optional, Tuple, Union

from flatland_server.exceptions import MessageError, shortened, suggestion

NUMBERS = {
    **{"bool": "?", "byte": "b", "char": "B", "float32": "f", "float64": "d"},
    **{"int8": "b", "int16": "h", "int32": "i", "int64": "q"},
    **{"uint8": "B", "uint16": "H", "uint32": "I", "uint64": "Q"},
}
"""The numeric types, with their formats in the module struct."""

INTEGERS = {
    name: (0, 2**bits - 1) if name[0] in "uc" else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for name, letter in NUMBERS.items()
    if letter not in "?fd"
    for bits in (8 * struct.calcsize(letter),)
}
"""The integer types, with their least and largest values."""

BUILT_IN = (*NUMBERS, "string", "time", "duration")

_NAME = r"[A-Za-z]\w*"
_TYPE_NAME = re.compile(rf"{_NAME}/{_NAME}")
_FIELD = re.compile(
    rf"(?P<base>{_NAME}(?:/{_NAME})?)(?P<array>\[(?P<length>\d*)\])?\s+(?P<name>{_NAME})"
)
_CONSTANT = re.compile(rf"(?P<type>{_NAME})\s+(?P<name>{_NAME})\s*=(?P<value>.*)")


class FieldType(NamedTuple):
    """The type of a field.

    Attributes:
        base: a built-in type or the full name of a message type; of the items of an array.
        is_array: whether it is an array.
        length: of an array with a fixed length.
    """

    base: str
    is_array: bool = False
    length: Optional[int] = None

    def __str__(self) -> str:
        length = "" if self.length is None else self.length
        return f"{self.base}[{length}]" if self.is_array else self.base


class Constant(NamedTuple):
    """A constant: its type, its name, its value as it is written, and the value itself."""

    type: str
    name: str
    written: str
    value: Union[int, float, str, bool]


@dataclass(frozen=True)
class Definition:
    """The definition of a message type.

    Attributes:
        name: of the type, such as `sensor_msgs/LaserScan`.
        text: the definition as it was written, without the types that it uses.
        fields: names and types, in their order.
        constants: in their order.
    """

    name: str
    text: str
    fields: Tuple[Tuple[str, FieldType], ...]
    constants: Tuple[Constant, ...]

    @classmethod
    def parse(cls, name: str, text: str, source: str = "") -> "Definition":
        """Reads a definition.

        Args:
            name: the type's name.
            text: in the .msg grammar.
            source: the file, for errors; by default the type's name.

        Raises:
            MessageError: the name or a line is wrong.
        """
        check_type_name(name)
        if not isinstance(text, str):
            raise MessageError(f"{name}: expected a definition, found {shortened(repr(text))}")
        fields: List[Tuple[str, FieldType]] = []
        constants: List[Constant] = []
        names = set()
        for number, line in enumerate(text.splitlines(), 1):
            try:
                part = _parse_line(line, name.partition("/")[0])
                if part is None:
                    continue
                part_name = part.name if isinstance(part, Constant) else part[0]
                if part_name in names:
                    raise ValueError(f'expected each name once, found "{part_name}" again')
            except ValueError as error:
                raise MessageError(f"{source or name}:{number}: {error}") from None
            names.add(part_name)
            if isinstance(part, Constant):
                constants.append(part)
            else:
                fields.append(part)
        return cls(name, text, tuple(fields), tuple(constants))

    @property
    def uses(self) -> List[str]:
        """The message types of its fields, each once."""
        bases = [field_type.base for _, field_type in self.fields]
        return list(dict.fromkeys(base for base in bases if base not in BUILT_IN))

    def md5(self, md5_of: Callable[[str], str]) -> str:
        """The MD5 sum by which ROS tells whether two nodes mean the same type.

        Args:
            md5_of: returns the sum of a type that this one contains.
        """
        lines = [f"{each.type} {each.name}={each.written}" for each in self.constants]
        for field, kind in self.fields:
            lines.append(f"{kind if kind.base in BUILT_IN else md5_of(kind.base)} {field}")
        return hashlib.md5("\n".join(lines).encode()).hexdigest()


def full_text(definition: Definition, others: Iterable[Definition]) -> str:
    """A definition with those of all types that it uses, as recordings and connections have it."""
    separator = "=" * 80
    parts = [f"{separator}\nMSG: {each.name}\n{each.text.strip()}\n" for each in others]
    return "\n".join([f"{definition.text.strip()}\n", *parts])


def split_full_text(name: str, text: str) -> Iterator[Tuple[str, str]]:
    """The names and texts of the definitions in a full text; the first has the given name."""
    for part in re.split(r"^={80}\n", text, flags=re.MULTILINE):
        if part.startswith("MSG: "):
            head, _, part = part.partition("\n")
            name = head[len("MSG: ") :].strip()
        yield name, part


def check_type_name(name: object) -> None:
    """Raises a MessageError unless it is the full name of a message type."""
    if not (isinstance(name, str) and _TYPE_NAME.fullmatch(name)):
        found = shortened(repr(name))
        raise MessageError(
            f'expected the name of a message type, such as "geometry_msgs/Twist", found {found}'
        )


def _parse_line(line: str, package: str) -> Union[Constant, Tuple[str, FieldType], None]:
    """A line's constant or field.

    Raises:
        ValueError: the line is wrong.
    """
    code = line.partition("#")[0].strip()
    if not code:
        return None
    constant = _CONSTANT.fullmatch(line.strip() if code.startswith("string ") else code)
    if constant and constant["type"] in BUILT_IN:
        return _constant(constant["type"], constant["name"], constant["value"].strip())
    field = _FIELD.fullmatch(code)
    if field is None:
        raise ValueError(
            "expected a type and a name, with a value if it is a constant, "
            f'found "{shortened(code)}"'
        )
    if iskeyword(field["name"]):
        raise ValueError(f'expected a name that is no keyword of Python, found "{field["name"]}"')
    length = int(field["length"]) if field["length"] else None
    base = _resolved(field["base"], package)
    return field["name"], FieldType(base, field["array"] is not None, length)


def _resolved(base: str, package: str) -> str:
    """The full name of a type that a definition in a package uses."""
    if base in BUILT_IN or "/" in base:
        return base
    if base == "Header":
        return "std_msgs/Header"
    if base[0].islower():
        hint = suggestion(base, BUILT_IN)
        raise ValueError(f'expected a type, found "{shortened(base)}"{hint}')
    return f"{package}/{base}"


def _constant(kind: str, name: str, written: str) -> Constant:
    try:
        if kind == "string":
            return Constant(kind, name, written, written)
        if kind in ("float32", "float64"):
            return Constant(kind, name, written, float(written))
        if kind == "bool":
            is_word = written.lower() in ("true", "false")
            value = written.lower() == "true" if is_word else bool(int(written))
            return Constant(kind, name, written, value)
        if kind in NUMBERS:
            return Constant(kind, name, written, int(written))
    except ValueError:
        pass
    raise ValueError(f'expected the value of a {kind} constant, found "{shortened(written)}"')

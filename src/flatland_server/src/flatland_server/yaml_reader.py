"""Checked values out of YAML, with the file and line of whatever is wrong.

A `YamlReader` stands for one mapping. Its getters name a key, what it must be and its default;
`finish` refuses the keys that nobody asked for. Values are read as what is asked for, not as what
YAML guesses: `1e3` and `inf` are numbers where a number is due.
"""

import math
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, Tuple, Union, cast

import yaml

from flatland_server.exceptions import YamlError, suggestion
from flatland_server.geometry import Pose

Color = Tuple[float, float, float, float]

REQUIRED: Any = object()
"""As a default: the key must be there."""

_TRUE = {"true", "yes", "on", "y"}
_FALSE = {"false", "no", "off", "n"}
_INFINITE = {"inf", ".inf", "+inf", "+.inf"}


class YamlReader:
    """One mapping of a YAML document.

    Args:
        node: the composed mapping.
        file: the file that it stands in.
        path: where it stands in the document, such as `models[0]`; empty for the whole.
    """

    def __init__(self, node: yaml.Node, file: Path, path: str = "") -> None:
        self.file = file
        self.path = path
        self._node = node
        self._values: Dict[str, yaml.Node] = {}
        self._read: Set[str] = set()
        if not isinstance(node, yaml.MappingNode):
            raise self._error(node, path, f"expected a map, found {_describe(node)}")
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise self._error(key, path, f"expected a key, found {_describe(key)}")
            if key.value in self._values:
                raise self._error(key, path, f'the key "{key.value}" is given twice')
            self._values[key.value] = value

    @classmethod
    def from_file(cls, path: Path) -> "YamlReader":
        """The mapping that a file consists of.

        Raises:
            YamlError: it is missing, unreadable, empty, not YAML or not a mapping.
        """
        try:
            text = path.read_bytes().decode("utf-8")
            node = yaml.compose(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        except OSError as error:
            raise YamlError(path, f"cannot be read: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise YamlError(path, f"is not UTF-8 text: byte {error.start} is wrong") from None
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark
            line, column = (mark.line + 1, mark.column + 1) if mark else (None, None)
            problem = " ".join(part for part in (error.context, error.problem) if part)
            raise YamlError(path, f"is not valid YAML: {problem}", line, column) from None
        except (yaml.YAMLError, RecursionError) as error:
            raise YamlError(path, f"is not valid YAML: {error}") from None
        if node is None:
            raise YamlError(path, "expected a map, found an empty file")
        return cls(node, path)

    # Values

    def has(self, key: str) -> bool:
        """Whether the key is given; a `null` counts as not given."""
        value = self._values.get(key)
        return value is not None and not _is_null(value)

    def get_string(self, key: str, default: Any = REQUIRED) -> str:
        """A text; may be empty."""
        return cast(str, self._get(key, default, _to_string))

    def get_float(
        self,
        key: str,
        default: Any = REQUIRED,
        *,
        minimum: float = -math.inf,
        above: float = -math.inf,
        allow_infinity: bool = False,
    ) -> float:
        """A number, at least `minimum` and larger than `above`; never NaN."""

        def convert(node: yaml.Node) -> float:
            value = _to_float(node)
            if math.isinf(value) and not allow_infinity:
                raise _Unexpected("a finite number")
            if value < minimum:
                raise _Unexpected(f"a number of {minimum:g} or more")
            if value <= above:
                raise _Unexpected(f"a number above {above:g}")
            return value

        return cast(float, self._get(key, default, convert))

    def get_rate(self, key: str, default: Any = REQUIRED) -> float:
        """A rate [Hz] above zero; `inf` is as often as possible."""
        return self.get_float(key, default, above=0.0, allow_infinity=True)

    def get_int(self, key: str, default: Any = REQUIRED, *, minimum: Optional[int] = None) -> int:
        """A whole number."""

        def convert(node: yaml.Node) -> int:
            try:
                value = int(_to_string(node))
            except ValueError:
                raise _Unexpected("a whole number") from None
            if minimum is not None and value < minimum:
                raise _Unexpected(f"a whole number of {minimum} or more")
            return value

        return cast(int, self._get(key, default, convert))

    def get_bool(self, key: str, default: Any = REQUIRED) -> bool:
        """True or false, in any of YAML's spellings."""

        def convert(node: yaml.Node) -> bool:
            text = _to_string(node).lower()
            if text not in _TRUE | _FALSE:
                raise _Unexpected("true or false")
            return text in _TRUE

        return cast(bool, self._get(key, default, convert))

    def get_choice(self, key: str, choices: Sequence[str], default: Any = REQUIRED) -> str:
        """One of some words."""

        def convert(node: yaml.Node) -> str:
            text = _to_string(node)
            if text not in choices:
                words = ", ".join(choices[:-1]) + " or " + choices[-1]
                raise _Unexpected(f"{words}{suggestion(text, choices)}")
            return text

        return cast(str, self._get(key, default, convert))

    def get_floats(
        self, key: str, length: int, default: Any = REQUIRED, *, minimum: float = -math.inf
    ) -> Tuple[float, ...]:
        """A list of `length` finite numbers, each at least `minimum`."""
        shown = f"a list of {length} numbers"
        if minimum > -math.inf:
            shown += f" of {minimum:g} or more"
        return self._get_floats(key, length, default, shown, minimum)

    def get_pose(self, key: str, default: Any = REQUIRED) -> Pose:
        """`[x, y, yaw]`."""
        return Pose(*self._get_floats(key, 3, default, "[x, y, yaw]"))

    def get_point(self, key: str, default: Any = REQUIRED) -> Tuple[float, float]:
        """`[x, y]`."""
        return cast(Tuple[float, float], self._get_floats(key, 2, default, "[x, y]"))

    def get_points(self, key: str, minimum: int, maximum: int) -> List[Tuple[float, float]]:
        """A list of `minimum` to `maximum` points `[x, y]`."""

        def convert(node: yaml.Node) -> List[Tuple[float, float]]:
            items = node.value if isinstance(node, yaml.SequenceNode) else []
            if not minimum <= len(items) <= maximum:
                raise _Unexpected(f"a list of {minimum} to {maximum} points [x, y]")
            return [cast(Tuple[float, float], _to_floats(item, 2, "[x, y]")) for item in items]

        return cast(List[Tuple[float, float]], self._get(key, REQUIRED, convert))

    def get_color(self, key: str, default: Any = REQUIRED) -> Color:
        """`[r, g, b, alpha]`, each 0 to 1."""
        return cast(Color, self._get_floats(key, 4, default, "[r, g, b, alpha]", 0.0, 1.0))

    def get_strings(self, key: str, default: Any = REQUIRED) -> Tuple[str, ...]:
        """A list of texts; a single text is a list of one."""

        def convert(node: yaml.Node) -> Tuple[str, ...]:
            if isinstance(node, yaml.SequenceNode):
                return tuple(_to_string(item) for item in node.value)
            return (_to_string(node),)

        return cast(Tuple[str, ...], self._get(key, default, convert))

    # Sections

    def get_section(self, key: str, *, required: bool = False) -> "YamlReader":
        """A mapping within this one; an empty one if it is not given and not required."""
        self._read.add(key)
        path = self._path_of(key)
        if not self.has(key):
            if required and key not in self._values:
                raise self._missing(key)
            empty = yaml.MappingNode("tag:yaml.org,2002:map", [], self._node.start_mark)
            return YamlReader(empty, self.file, path)
        return YamlReader(self._values[key], self.file, path)

    def get_sections(self, key: str, *, required: bool = False) -> List["YamlReader"]:
        """A list of mappings; an empty list if it is not given and not required."""
        self._read.add(key)
        path = self._path_of(key)
        if not self.has(key):
            if required:
                raise self._missing(key)
            return []
        node = self._values[key]
        if not isinstance(node, yaml.SequenceNode):
            raise self._error(node, path, f"expected a list, found {_describe(node)}")
        return [
            YamlReader(item, self.file, f"{path}[{index}]") for index, item in enumerate(node.value)
        ]

    # Errors

    def finish(self) -> None:
        """Refuses keys that no getter has asked for.

        Raises:
            YamlError: there is one; the nearest known key is suggested.
        """
        for key, value in self._values.items():
            if key not in self._read:
                hint = suggestion(key, self._read - self._values.keys())
                raise self._error(value, self._label(), f'unknown key "{key}"{hint}')

    def error(self, message: str, key: Optional[str] = None) -> YamlError:
        """An error at a key's value, or at this mapping, for whoever knows more than the reader."""
        if key is None or key not in self._values:
            return self._error(self._node, self._label(), message)
        return self._error(self._values[key], self._path_of(key), message)

    def _missing(self, key: str) -> YamlError:
        return self.error(f'the required key "{key}" is missing')

    def _error(self, node: yaml.Node, path: str, message: str) -> YamlError:
        mark = node.start_mark
        message = f"{path}: {message}" if path else message
        return YamlError(self.file, message, mark.line + 1, mark.column + 1)

    def _path_of(self, key: str) -> str:
        return f"{self.path}.{key}" if self.path else key

    def _label(self) -> str:
        name = self._values.get("name")
        if self.path.endswith("]") and isinstance(name, yaml.ScalarNode):
            return f'{self.path} "{name.value}"'
        return self.path

    def _get(self, key: str, default: Any, convert: Callable[[yaml.Node], Any]) -> Any:
        self._read.add(key)
        if not self.has(key):
            if default is REQUIRED:
                raise self._missing(key)
            return default
        node = self._values[key]
        try:
            return convert(node)
        except _Unexpected as unexpected:
            message = f"expected {unexpected}, found {_describe(node)}"
            raise self._error(node, self._path_of(key), message) from None

    def _get_floats(
        self,
        key: str,
        length: int,
        default: Any,
        shown: str,
        minimum: float = -math.inf,
        maximum: float = math.inf,
    ) -> Tuple[float, ...]:
        def convert(node: yaml.Node) -> Tuple[float, ...]:
            values = _to_floats(node, length, shown)
            if any(not minimum <= value <= maximum for value in values):
                raise _Unexpected(shown)
            return values

        return cast(Tuple[float, ...], self._get(key, default, convert))


class _Unexpected(Exception):
    """What a getter expected; `_get` adds where and what was found."""


def _is_null(node: yaml.Node) -> bool:
    return node.tag == "tag:yaml.org,2002:null"


def _to_string(node: yaml.Node) -> str:
    if not isinstance(node, yaml.ScalarNode):
        raise _Unexpected("a text")
    return str(node.value)


def _to_float(node: yaml.Node) -> float:
    text = node.value if isinstance(node, yaml.ScalarNode) else ""
    if text.lower() in _INFINITE:
        return math.inf
    if text.lower() in {"-inf", "-.inf"}:
        return -math.inf
    try:
        value = float(text)
    except ValueError:
        raise _Unexpected("a number") from None
    if math.isnan(value):
        raise _Unexpected("a number")
    return value


def _to_floats(node: yaml.Node, length: int, shown: str) -> Tuple[float, ...]:
    if not isinstance(node, yaml.SequenceNode) or len(node.value) != length:
        raise _Unexpected(shown)
    try:
        values = tuple(_to_float(item) for item in node.value)
    except _Unexpected:
        raise _Unexpected(shown) from None
    if not all(math.isfinite(value) for value in values):
        raise _Unexpected(shown)
    return values


def _describe(node: Union[yaml.Node, Any]) -> str:
    """A value as its author would recognise it, cut to a readable length."""
    if isinstance(node, yaml.ScalarNode):
        if _is_null(node):
            return "nothing"
        quoted = node.tag == "tag:yaml.org,2002:str"
        text = f'"{node.value}"' if quoted else str(node.value)
    elif isinstance(node, yaml.SequenceNode):
        text = "[" + ", ".join(_describe(item) for item in node.value[:12]) + "]"
    else:
        return "a map"
    return text if len(text) <= 60 else text[:57] + "..."

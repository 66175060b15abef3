"""Checked values out of YAML, with the file and line of whatever is wrong.

A `YamlReader` stands for one mapping. Its getters name a key, what it must be and its default;
`finish` refuses the keys that nobody asked for. Values are read as what is asked for, not as what
YAML guesses: `1e3` and `inf` are numbers where a number is due.

So that all problems are reported together, a getter that meets one notes it and returns something
harmless of the right type; `finish` raises for all of them. Use no value before you have called it.
"""

import math
import os
from contextlib import closing
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, Tuple, TypeVar, cast

import yaml

from flatland_server.config.yaml_preprocessor import YamlPreprocessor, is_file
from flatland_server.config.yaml_values import (
    LARGEST,
    Unexpected,
    describe,
    is_null,
    to_bool,
    to_float,
    to_floats,
    to_int,
    to_string,
    to_strings,
)
from flatland_server.exceptions import Problem, YamlError, suggestion
from flatland_server.geometry import Pose

T = TypeVar("T")

Color = Tuple[float, float, float, float]

REQUIRED: Any = object()
"""As a default: the key must be there."""


class YamlReader:
    """One mapping of a YAML document.

    Args:
        node: the composed mapping, whose marks name its file.
        path: where it stands in the document, such as `models[0]`; empty for the whole.
        root: the file that the document begins in, if this mapping was included into it.

    Raises:
        YamlError: it is not a mapping, or a key is given twice.
    """

    def __init__(self, node: yaml.Node, path: str = "", root: Optional[Path] = None) -> None:
        self.file = Path(node.start_mark.name)
        self.path = path
        self._root = root or self.file
        self._node = node
        self._keys: Dict[str, yaml.Node] = {}
        self._values: Dict[str, yaml.Node] = {}
        self._read: Set[str] = set()
        self._problems: List[Problem] = []
        self._is_within = False  # part of a mapping that raises this one's problems too
        if not isinstance(node, yaml.MappingNode):
            raise _error(node, path, f"expected a map, found {describe(node)}")
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise _error(key, path, f"expected a key, found {describe(key)}")
            if key.value in self._values:
                self._note(_error(key, path, f'the key "{key.value}" is given twice'))
            self._keys[key.value], self._values[key.value] = key, value

    @classmethod
    def from_file(cls, path: Path, preprocessor: Optional[YamlPreprocessor] = None) -> "YamlReader":
        """The mapping that a file consists of, its includes and expressions resolved.

        Args:
            path: of the file.
            preprocessor: has the parameters; by default there are none.

        Raises:
            YamlError: it is missing, unreadable, empty, not YAML or not a mapping.
        """
        if preprocessor is not None:
            return cls(preprocessor.read(path))
        with closing(YamlPreprocessor()) as own:
            return cls(own.read(path))

    # Values

    def has(self, key: str) -> bool:
        """Whether the key is given; a `null` counts as not given."""
        value = self._values.get(key)
        return value is not None and not is_null(value)

    def get_string(self, key: str, default: Any = REQUIRED) -> str:
        """A text; may be empty."""
        return cast(str, self._get(key, default, to_string, ""))

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
            value = to_float(node)
            if math.isinf(value):
                if not allow_infinity:
                    raise Unexpected("a finite number")
            elif abs(value) > LARGEST:
                raise Unexpected(f"a number within {LARGEST:g} of zero")
            if value < minimum:
                raise Unexpected(f"a number of {minimum:g} or more")
            if value <= above:
                raise Unexpected(f"a number above {above:g}")
            return value

        harmless = 1.0 if minimum <= 1.0 and above < 1.0 else max(minimum, above + 1.0)
        return cast(float, self._get(key, default, convert, harmless))

    def get_rate(self, key: str, default: Any = REQUIRED) -> float:
        """A rate [Hz] above zero; `inf` is as often as possible."""
        return self.get_float(key, default, above=0.0, allow_infinity=True)

    def get_int(
        self,
        key: str,
        default: Any = REQUIRED,
        *,
        minimum: Optional[int] = None,
        maximum: Optional[int] = None,
    ) -> int:
        """A whole number, at least `minimum` and at most `maximum`."""

        def convert(node: yaml.Node) -> int:
            value = to_int(node)
            if minimum is not None and value < minimum:
                raise Unexpected(f"a whole number of {minimum} or more")
            if maximum is not None and value > maximum:
                raise Unexpected(f"a whole number of {maximum} or less")
            return value

        return cast(int, self._get(key, default, convert, minimum or 0))

    def get_bool(self, key: str, default: Any = REQUIRED) -> bool:
        """True or false, in any of YAML's spellings."""
        return cast(bool, self._get(key, default, to_bool, True))

    def get_choice(self, key: str, choices: Sequence[str], default: Any = REQUIRED) -> str:
        """One of some words. What else there must be hangs on it: a wrong one raises at once."""

        def convert(node: yaml.Node) -> str:
            text = to_string(node)
            if text not in choices:
                words = ", ".join(choices[:-1]) + " or " + choices[-1]
                raise Unexpected(f"{words}{suggestion(text, choices)}")
            return text

        return cast(str, self._get(key, default, convert, None))

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

    def get_points(
        self, key: str, minimum: int, maximum: int, default: Any = REQUIRED
    ) -> List[Tuple[float, float]]:
        """A list of `minimum` to `maximum` points `[x, y]`."""

        def convert(node: yaml.Node) -> List[Tuple[float, float]]:
            items = node.value if isinstance(node, yaml.SequenceNode) else []
            if not minimum <= len(items) <= maximum:
                raise Unexpected(f"a list of {minimum} to {maximum} points [x, y]")
            return [cast(Tuple[float, float], to_floats(item, 2, "[x, y]")) for item in items]

        # On a parabola: a convex polygon, however many they are.
        harmless = [(float(i), float(i * i)) for i in range(minimum)]
        return cast(List[Tuple[float, float]], self._get(key, default, convert, harmless))

    def get_color(self, key: str, default: Any = REQUIRED) -> Color:
        """`[r, g, b, alpha]`, each 0 to 1."""
        return cast(Color, self._get_floats(key, 4, default, "[r, g, b, alpha]", 0.0, 1.0))

    def get_strings(self, key: str, default: Any = REQUIRED) -> Tuple[str, ...]:
        """A list of texts; a single text is a list of one."""
        return cast(Tuple[str, ...], self._get(key, default, to_strings, ()))

    def get_path(self, key: str) -> Path:
        """A file that is there: absolute, or relative to the document or to where the key is.

        A document that is a link is looked at where the link is, and where the file is.
        """
        noted = len(self._problems)
        name = self.get_string(key)
        candidates = [self._root.parent / name, self._root.resolve().parent / name]
        if key in self._values:
            candidates.append(Path(self._values[key].start_mark.name).parent / name)
        for path in candidates:
            if is_file(path):
                return path
        if len(self._problems) > noted:
            pass  # it is not even a text
        elif name:
            kind = "is a folder" if os.path.isdir(candidates[0]) else "is not there"
            self.problem(f"expected a file, but {candidates[0]} {kind}", key)
        else:
            self.problem("expected a file, found an empty text", key)
        return candidates[0]

    # Sections

    def get_section(self, key: str, *, required: bool = False) -> "YamlReader":
        """A mapping within this one; an empty one if it is not given and not required.

        Its problems are raised by this mapping's `finish`; its own only looks for unknown keys.
        """
        self._read.add(key)
        node: yaml.Node = yaml.MappingNode("tag:yaml.org,2002:map", [], self._node.start_mark)
        is_usable = True
        if self.has(key):
            is_usable = isinstance(self._values[key], yaml.MappingNode)
            if is_usable:
                node = self._values[key]
            else:
                found = describe(self._values[key])
                self.problem(f"expected a map, found {found}", key)
        elif required and key not in self._values:
            is_usable = False
            self._note(self._missing(key))
        section = YamlReader(node, self._path_of(key), self._root)
        if is_usable:  # otherwise what is missing within follows from what was said
            self._problems.extend(section._problems)
            section._problems = self._problems
        section._is_within = True
        return section

    def get_sections(
        self, key: str, read: Callable[["YamlReader"], T], *, required: bool = False
    ) -> List[T]:
        """What `read` makes of each mapping of a list; an empty list if it is not given.

        The problems that `read` raises are noted; what it cannot read is left out.
        """
        self._read.add(key)
        path = self._path_of(key)
        if not self.has(key):
            if required:
                self._note(self._missing(key))
            return []
        node = self._values[key]
        if not isinstance(node, yaml.SequenceNode):
            self._note(_error(node, path, f"expected a list, found {describe(node)}"))
            return []
        results = []
        for index, item in enumerate(node.value):
            try:
                results.append(read(YamlReader(item, f"{path}[{index}]", self._root)))
            except YamlError as error:
                self._note(error)
        return results

    # Problems

    @property
    def is_sound(self) -> bool:
        """Whether nothing wrong was noted so far."""
        return not self._problems

    def problem(self, message: str, key: Optional[str] = None) -> None:
        """Notes something wrong at a key's value, or with this mapping; `finish` raises it."""
        self._note(self.error(message, key))

    def suggest(self, missing: str) -> None:
        """Notes keys that look like a misspelt one, where nobody can tell yet which are unknown."""
        for key, node in self._keys.items():
            hint = suggestion(key, [missing])
            if key not in self._read and hint:
                self._note(_error(node, self._label(), f'unknown key "{key}"{hint}'))

    def finish(self) -> None:
        """Refuses keys that no getter has asked for, and raises all that was noted.

        Raises:
            YamlError: there is something; for an unknown key the nearest known one is suggested.
        """
        for key, node in self._keys.items():
            if key not in self._read:
                hint = suggestion(key, self._read - self._keys.keys())
                self._note(_error(node, self._label(), f'unknown key "{key}"{hint}'))
        self._read.update(self._values)
        if not self._is_within:
            self.raise_problems()

    def raise_problems(self) -> None:
        """Raises what was noted so far, where going on would only lead to more."""
        if self._problems:
            problems, self._problems = self._problems, []
            raise YamlError.of(problems)

    def error(self, message: str, key: Optional[str] = None) -> YamlError:
        """An error at a key's value, or at this mapping, to raise at once."""
        if key is None or key not in self._values:
            return _error(self._node, self._label(), message)
        return _error(self._values[key], self._path_of(key), message)

    def note(self, error: YamlError) -> None:
        """Notes the problems of another file that this mapping refers to."""
        self._note(error)

    def _note(self, error: YamlError) -> None:
        self._problems.extend(error.problems)

    def _missing(self, key: str) -> YamlError:
        return self.error(f'the required key "{key}" is missing')

    def _path_of(self, key: str) -> str:
        return f"{self.path}.{key}" if self.path else key

    def _label(self) -> str:
        name = self._values.get("name")
        if self.path.endswith("]") and isinstance(name, yaml.ScalarNode):
            return f'{self.path} "{name.value}"'
        return self.path

    def _get(
        self, key: str, default: Any, convert: Callable[[yaml.Node], Any], harmless: Any
    ) -> Any:
        """A key's value; if it is missing or wrong, notes that and returns `harmless`.

        Without anything harmless, None, it raises, with what was noted before.
        """
        self._read.add(key)
        if not self.has(key):
            if default is not REQUIRED:
                return default
            self._note(self._missing(key))
        else:
            node = self._values[key]
            try:
                return convert(node)
            except Unexpected as unexpected:
                message = f"expected {unexpected}, found {describe(node)}"
                self._note(_error(node, self._path_of(key), message))
        if harmless is None:
            raise YamlError.of(self._problems)
        return harmless

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
            values = to_floats(node, length, shown)
            if any(not minimum <= value <= maximum for value in values):
                raise Unexpected(shown)
            return values

        harmless = (max(0.0, minimum),) * length
        return cast(Tuple[float, ...], self._get(key, default, convert, harmless))


def _error(node: yaml.Node, path: str, message: str) -> YamlError:
    mark = node.start_mark
    message = f"{path}: {message}" if path else message
    return YamlError(Path(mark.name), message, mark.line + 1, mark.column + 1)

"""One map of a YAML document: its keys, and the problems found in it."""

import logging
import math
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Set, Union

import yaml

from flatland_server.config.plain_nodes import NO_LINE, to_content
from flatland_server.config.ros_names import topic_name_problem
from flatland_server.config.syntax_errors import other_indentation
from flatland_server.config.yaml_values import ConversionError, describe, is_null
from flatland_server.exceptions import MAX_SHOWN, Problem, YamlError, shortened, suggestion

logger = logging.getLogger(__name__)

_KEYS_OF_FORKS = {"flipped": "upside_down"}
"""Keys of other Flatlands' plugins, and those that do the same here: docs/coming_from_cpp.md."""

Written = Union[yaml.Node, yaml.Event]
"""A part of a file, with its place."""

REQUIRED: Any = object()
"""As a default: the key must be given."""


class ProblemCollector:
    """The problems found in a document so far, each once, in the order in which they were found.

    The readers of a document and of the sections in it share one collector. An entry of a list has
    a collector of its own, because it is read or left out as a whole; the document takes over its
    problems when it has been read (see `part`).

    Args:
        before: how many problems were found in the document before.
    """

    def __init__(self, before: int = 0) -> None:
        self._problems: Dict[Problem, None] = {}  # a set that keeps its order
        self._before = before

    @property
    def is_full(self) -> bool:
        """True if a further problem would only be counted, so that its text does not matter."""
        return self._before + len(self._problems) >= MAX_SHOWN

    @property
    def is_empty(self) -> bool:
        """True if no problem was found so far."""
        return not self._problems

    def note(self, error: YamlError) -> None:
        """Adds the problems of an error."""
        self._problems.update(dict.fromkeys(error.problems))

    def drop(self, error: YamlError) -> None:
        """Removes the problems of an error."""
        for problem in error.problems:
            self._problems.pop(problem, None)

    def clear(self) -> None:
        """Drops all problems."""
        self._problems.clear()

    def take(self) -> YamlError:
        """All problems as one error, to be raised; none are left. There must be one at least."""
        error = YamlError.of(self._problems)
        self.clear()
        return error

    @contextmanager
    def part(self) -> Iterator["ProblemCollector"]:
        """A collector for an entry of a list, while that is read.

        A YamlError ends the block and is noted. At the end of the block, the problems of the entry
        are added to those of the document.
        """
        part = ProblemCollector(self._before + len(self._problems))
        try:
            yield part
        except YamlError as error:
            part.note(error)
        self._problems.update(part._problems)


class MutedCollector(ProblemCollector):
    """Drops problems in a section that is missing or not a map, which is noted already.

    Args:
        document: collector of the document, which has the problem.
    """

    def __init__(self, document: ProblemCollector) -> None:
        super().__init__()
        self._document = document

    @property
    def is_empty(self) -> bool:
        return self._document.is_empty

    def note(self, error: YamlError) -> None:
        pass

    def take(self) -> YamlError:
        return self._document.take()


class YamlMap:
    """A map, its keys that were read so far, and the problems found in it.

    Args:
        node: the composed mapping; its marks name the file.
        path: its place in the document, such as `models[0]`; empty for the whole document.
        root: the file of the document, if the map was included into it from another one.
        problems: where problems are noted; by default in a collector of its own.

    Raises:
        YamlError: it is not a map, or one of its keys is a list or a map.
    """

    def __init__(
        self,
        node: yaml.Node,
        path: str = "",
        root: Optional[Path] = None,
        problems: Optional[ProblemCollector] = None,
    ) -> None:
        self.file = file_of(node)
        """The file that the map is written in."""
        self.path = path
        """The map's place in the document, such as `models[0]`; empty for the whole document."""
        self._root = root or self.file
        self._node = node
        self._keys: Dict[str, yaml.Node] = {}
        self._values: Dict[str, yaml.Node] = {}
        self._read: Set[str] = set()
        self._repeated: List[YamlError] = []
        self._results: Dict[Any, Any] = {}  # of `YamlReader.read_once`
        self._problems = ProblemCollector() if problems is None else problems
        if not isinstance(node, yaml.MappingNode):
            raise error_at(node, f"expected a map, found {describe(node)}", path)
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise error_at(key, f"expected a key, found {describe(key)}", path)
            if key.value in self._values:
                error = error_at(key, f'the key "{shortened(key.value)}" is given twice', path)
                self._repeated.append(error)
                self.note(error)
            self._keys[key.value], self._values[key.value] = key, value

    def has(self, key: str) -> bool:
        """True if the key is given; a `null` counts as not given.

        Args:
            key: key of this map, as it is written in the file.
        """
        return key in self._values and not is_null(self._values[key])

    def is_list(self, key: str) -> bool:
        """True if a value is a list, for keys that take a list or something else.

        Args:
            key: key of this map, as it is written in the file.
        """
        return isinstance(self._values.get(key), yaml.SequenceNode)

    def is_map(self, key: str) -> bool:
        """True if a value is a map, for keys that take a map or something else.

        Args:
            key: key of this map, as it is written in the file.
        """
        return isinstance(self._values.get(key), yaml.MappingNode)

    def content(self) -> Dict[str, Any]:
        """The map as plain data, as `YamlReader.from_content` takes it."""
        content: Dict[str, Any] = to_content(self._node)
        return content

    def key_of(self, value: str) -> Optional[str]:
        """The first key with a certain value, or None.

        Args:
            value: scalar value to look for.
        """
        for key, node in self._values.items():
            if isinstance(node, yaml.ScalarNode) and node.value == value:
                return key
        return None

    @property
    def is_sound(self) -> bool:
        """True if no problem was noted so far."""
        return self._problems.is_empty

    def problem(self, message: str, key: Optional[str] = None) -> None:
        """Notes a problem at a key's value, or with this map; `finish` raises it.

        Args:
            message: the text of the problem, without the place.
            key: of the value; None for this map.
        """
        self.note(self.error(message, key))

    def note(self, error: YamlError) -> None:
        """Notes the problems of an error, such as those of a file that this map refers to.

        Args:
            error: error with the problems to note.
        """
        self._problems.note(error)

    def error(self, message: str, key: Optional[str] = None) -> YamlError:
        """An error at a key's value, or at this map, to be raised at once.

        Args:
            message: the text of the error, without the place.
            key: of the value; None for this map.
        """
        if key is None or key not in self._values:
            return error_at(self._node, message, self._label())
        return error_at(self._values[key], message, self._path_of(key))

    def suggest(self, missing: str) -> None:
        """Notes keys that look like a misspelling of one that is missing.

        For a map of which some keys are read later, so that `finish` cannot be called yet.

        Args:
            missing: the key that is missing.
        """
        for key in self._unread():
            hint = self.suggestion(key, [missing])
            if hint:
                self._note_unknown_key(key, hint)

    def suggestion(self, word: str, known: Iterable[str]) -> str:
        """A hint for a misspelt word; see `flatland_server.exceptions.suggestion`.

        To save time, it is empty if there are already more problems than are shown.

        Args:
            word: the word that was found.
            known: the words that are valid.
        """
        return "" if self._problems.is_full else suggestion(word, known)

    def warn(self, message: str, key: Optional[str] = None) -> None:
        """Logs a warning about something valid that is probably not meant, once in a process.

        Args:
            message: the text of the warning, without the place.
            key: of the value; None for this map.
        """
        warn_once(str(self.error(message, key)))

    def warn_of_degrees(self, angle: float, key: str) -> None:
        """Warns of an angle of more than a revolution [rad].

        Args:
            angle: the angle that was read [rad].
            key: key of the angle.
        """
        if math.tau + 0.01 < abs(angle) < math.inf:
            self.warn(f"expected an angle in rad, found {angle:g}: is it in degrees?", key)

    def raise_problems(self) -> None:
        """Raises the problems noted so far, if reading on would only cause more.

        Raises:
            YamlError: a problem was noted in this document or entry, its sections included.
        """
        if not self._problems.is_empty:
            raise self._problems.take()

    def finish(self) -> None:
        """Refuses keys that no getter has asked for, and raises all problems.

        Raises:
            YamlError: a problem was noted in this document or entry, its sections included. The
                message for an unknown key suggests the most similar known one.
        """
        self._note_unknown_keys()
        self.raise_problems()

    def accept_repeated_keys(self) -> None:
        """Makes keys that are given twice a warning; the last one counts."""
        for error in self._repeated:
            self._problems.drop(error)
            warn_once(f"{error}; the last one counts")
        self._repeated.clear()

    def accept_other_keys(self) -> None:
        """Makes `finish` accept keys that no getter has asked for."""
        self._read.update(self._keys)

    def _note_unknown_keys(self) -> None:
        not_given = [key for key in self._read if key not in self._keys]
        for key in self._unread():
            ours = _KEYS_OF_FORKS.get(key)
            hint = f' (here it is "{ours}")' if ours in not_given else ""
            self._note_unknown_key(key, hint or self.suggestion(key, not_given))
        self._read.update(self._keys)

    def _note_unknown_key(self, key: str, hint: str) -> None:
        indentation = other_indentation(key)
        hint = f" ({indentation})" if indentation else hint
        self.note(error_at(self._keys[key], f'unknown key "{shortened(key)}"{hint}', self._label()))

    def _unread(self) -> List[str]:
        return [key for key in self._keys if key not in self._read]

    def _missing(self, key: str) -> YamlError:
        return self.error(f'the required key "{key}" is missing')

    def _value(self, key: str, default: Any, converter: Callable[[yaml.Node], Any]) -> Any:
        """A key's value, or the default.

        Raises:
            YamlError: it is missing or wrong.
        """
        self._read.add(key)
        if not self.has(key):
            if default is not REQUIRED:
                return default
            if key in self._keys:
                message = f'the required key "{key}" has no value'
                raise error_at(self._keys[key], message, self._label())
            raise self._missing(key)
        try:
            return converter(self._values[key])
        except ConversionError as error:
            node, place = self._values[key], self._path_of(key)
            if error.index is not None:
                node, place = node.value[error.index], f"{place}[{error.index}]"
            raise error_at(node, f"expected {error}, found {describe(node)}", place) from None

    def _get(
        self, key: str, default: Any, converter: Callable[[yaml.Node], Any], placeholder: Any
    ) -> Any:
        """Like `_value`, but notes a missing or wrong value and returns the placeholder."""
        try:
            return self._value(key, default, converter)
        except YamlError as error:
            self.note(error)
            return placeholder

    def _path_of(self, key: str) -> str:
        """The place of a key's value in the document."""
        return f"{self.path}.{key}" if self.path else key

    def _label(self) -> str:
        """The map's place in the document; for an entry of a list, with its name."""
        name = self._values.get("name")
        if self.path.endswith("]") and isinstance(name, yaml.ScalarNode):
            return f'{self.path} "{shortened(name.value)}"'
        return self.path


@lru_cache(maxsize=1000)
def warn_once(message: str) -> None:
    """Logs a warning that names its place, once: not again at each reset or in each environment."""
    logger.warning("%s", message)


def check_topic_name(reader: YamlMap, key: str, name: str) -> None:
    """Notes a problem if the name given at a key cannot be part of a topic.

    Args:
        reader: reader of the map with the key.
        key: key of the name, for the problem.
        name: name that is checked.
    """
    problem = topic_name_problem(name)
    if problem and reader.has(key):
        reader.problem(problem, key)


def file_of(node: Written) -> Path:
    """The file that a node is written in."""
    return _path(node.start_mark.name)


@lru_cache(maxsize=64)
def _path(name: str) -> Path:
    """A path, cached: each map of a file needs it, and making them took a twentieth of a spawn."""
    return Path(name)


def error_at(node: Written, message: str, path: str = "") -> YamlError:
    """An error at a node.

    Args:
        node: the node at fault.
        message: what is wrong with it.
        path: its place in the document, which is put before the message.
    """
    mark = node.start_mark
    message = f"{path}: {message}" if path else message
    if mark.line == NO_LINE:
        return YamlError(file_of(node), message)
    return YamlError(file_of(node), message, mark.line + 1, mark.column + 1)

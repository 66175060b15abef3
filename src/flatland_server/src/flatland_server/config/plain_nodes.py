"""Worlds and models as dicts and lists, converted to and from the nodes of parsed files."""

from os import PathLike, fspath
from typing import Any, Callable, Dict, List, Mapping, Sequence

import numpy as np
import yaml

from flatland_server.exceptions import FlatlandError, shortened

_TAG = "tag:yaml.org,2002:"
_MAX_DEPTH = 100

_YAML = yaml.constructor.SafeConstructor()
_CONVERTERS: Dict[str, Callable[[Any], Any]] = {
    "bool": _YAML.construct_yaml_bool,
    "float": _YAML.construct_yaml_float,
    "int": _YAML.construct_yaml_int,
}

NO_LINE = -2
"""The line number of a mark without a file."""


class ArrayNode(yaml.SequenceNode):
    """A list of rows of numbers as an array: a map of a million cells takes no million nodes.

    Args:
        array: shape (n, k), read-only.
        mark: place of the list in its file.
    """

    def __init__(self, array: Any, mark: yaml.Mark) -> None:
        self.tag = f"{_TAG}seq"
        self.start_mark = self.end_mark = mark
        self.array = array

    @property
    def value(self) -> List[yaml.Node]:
        """The rows as nodes, for callers that do not know arrays."""
        return [node_at(row, self.start_mark) for row in self.array.tolist()]


def plain_copy(content: Any, name: str, path: str = "", depth: int = 0) -> Any:
    """A copy of a file's content in Python's built-in types.

    Args:
        content: None, booleans, numbers, strings, paths, and lists, tuples, arrays and dicts of
            these.
        name: stands for the file in errors, such as "world".
        path: the place within the content, such as `models[0]`.
        depth: the number of lists and dicts around it.

    Raises:
        FlatlandError: a part of it has another type.

    Returns:
        None, booleans, numbers, strings, and lists and dicts of these; arrays of rows of numbers as
        read-only arrays.
    """
    where = f"{name}: {path}" if path else name
    if depth > _MAX_DEPTH:
        raise FlatlandError(f"{name}: expected at most {_MAX_DEPTH} levels, found more")
    if isinstance(content, np.ndarray) and content.ndim == 2 and content.dtype.kind in "biuf":
        rows = content.copy()
        rows.flags.writeable = False
        return rows
    if hasattr(content, "tolist"):  # arrays and numbers of NumPy
        content = content.tolist()
    if isinstance(content, PathLike):
        content = fspath(content)
    if content is None or isinstance(content, (bool, int, float, str)):
        return content
    if isinstance(content, Mapping):
        copy: Dict[str, Any] = {}
        for key, value in content.items():
            if not isinstance(key, str):
                raise FlatlandError(f"{where}: expected a string as a key, found {key!r}")
            copy[key] = plain_copy(value, name, f"{path}.{key}" if path else key, depth + 1)
        return copy
    if isinstance(content, Sequence) and not isinstance(content, bytes):
        return [
            plain_copy(value, name, f"{path}[{index}]", depth + 1)
            for index, value in enumerate(content)
        ]
    raise FlatlandError(
        f"{where}: expected numbers, strings, and lists and dicts of these, "
        f"found {shortened(repr(content))}"
    )


def to_node(content: Any, name: str, path: str = "") -> yaml.Node:
    """The YAML node of plain data, for a `YamlReader`.

    Args:
        content: as for `plain_copy`; strings that begin with "$eval" or "$include" are evaluated
            later, as in a file.
        name: stands for the file in errors.
        path: the place within the content.

    Raises:
        FlatlandError: as of `plain_copy`.
    """
    return node_at(plain_copy(content, name, path), yaml.Mark(name, 0, NO_LINE, 0, None, 0))


def to_content(node: yaml.Node) -> Any:
    """The inverse of `to_node`: None, booleans, numbers, strings, lists, dicts and new arrays.

    Args:
        node: node with its expressions and includes resolved.
    """
    if isinstance(node, yaml.MappingNode):
        return {key.value: to_content(value) for key, value in node.value}
    if isinstance(node, ArrayNode):
        return node.array.copy()
    if isinstance(node, yaml.SequenceNode):
        return [to_content(item) for item in node.value]
    kind = node.tag[len(_TAG) :]
    if kind == "null":
        return None
    return _CONVERTERS[kind](node) if kind in _CONVERTERS else node.value


def node_at(value: Any, mark: yaml.Mark) -> yaml.Node:
    """The YAML node of plain data at a place.

    Args:
        value: result of `plain_copy`.
        mark: the place.
    """
    if isinstance(value, dict):
        pairs = [(node_at(key, mark), node_at(item, mark)) for key, item in value.items()]
        return yaml.MappingNode(f"{_TAG}map", pairs, mark, mark)
    if isinstance(value, np.ndarray):
        return ArrayNode(value, mark)
    if isinstance(value, list):
        return yaml.SequenceNode(f"{_TAG}seq", [node_at(item, mark) for item in value], mark, mark)
    if value is None:
        return yaml.ScalarNode(f"{_TAG}null", "null", mark, mark)
    kind = {bool: "bool", int: "int", float: "float"}.get(type(value), "str")
    text = str(value).lower() if kind == "bool" else str(value)
    return yaml.ScalarNode(f"{_TAG}{kind}", text, mark, mark)

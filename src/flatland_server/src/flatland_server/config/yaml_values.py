"""Conversion of YAML nodes to values, and descriptions of nodes for error messages.

The functions `to_...` convert a node. The others return such a function for values that are
restricted further.
"""

import math
import sys
from typing import Any, Callable, List, Optional, Sequence, Tuple, TypeVar, cast

import numpy as np
import yaml

from flatland_server.arrays import FloatArray
from flatland_server.config.plain_nodes import ArrayNode, to_content
from flatland_server.exceptions import suggestion

T = TypeVar("T")

LARGEST = 1e9
"""The largest magnitude of a number: physics is computed in single precision."""

_TRUE = {"true", "yes", "on", "y"}
_FALSE = {"false", "no", "off", "n"}

_LONGEST = 60  # characters of a description
_MOST_ITEMS = 12  # of a list in a description


class ConversionError(Exception):
    """A node has another form than expected. The message is the expected one: "a whole number".

    Args:
        message: the form that was expected.
        index: index of the entry of a list that has it, from 0; None: the node itself.
    """

    def __init__(self, message: str, index: Optional[int] = None) -> None:
        super().__init__(message)
        self.index = index


def is_null(node: yaml.Node) -> bool:
    """True if a node is `null`, `~` or empty."""
    return node.tag == "tag:yaml.org,2002:null"


def to_string(node: yaml.Node) -> str:
    """The text of a scalar, whatever type YAML gives it."""
    if not isinstance(node, yaml.ScalarNode):
        raise ConversionError("a string")
    return str(node.value)


def to_strings(node: yaml.Node) -> Tuple[str, ...]:
    """The strings of a list; a single string is a list of one."""
    items = node.value if isinstance(node, yaml.SequenceNode) else [node]
    return tuple(to_string(item) for item in items)


def to_items(node: yaml.Node) -> List[yaml.Node]:
    """The items of a list, not converted."""
    if not isinstance(node, yaml.SequenceNode):
        raise ConversionError("a list")
    return cast(List[yaml.Node], node.value)


def to_bool(node: yaml.Node) -> bool:
    """True or false, in any of YAML's spellings."""
    text = to_string(node).lower()
    if text not in _TRUE | _FALSE:
        raise ConversionError("true or false")
    return text in _TRUE


def to_int(node: yaml.Node) -> int:
    """A whole number, in decimal notation."""
    try:
        return int(to_string(node).replace("_", "?"))  # int() takes 1_0 for 10
    except ValueError:
        raise ConversionError("a whole number") from None


def to_float(node: yaml.Node) -> float:
    """A number or infinity, in YAML's spelling or Python's; not NaN."""
    text = node.value if isinstance(node, yaml.ScalarNode) else ""
    if text.lower() in (".inf", "+.inf", "-.inf"):
        text = text.replace(".", "")
    try:
        value = float(text.replace("_", "?"))  # float() takes 1_0 for 10
    except ValueError:
        raise ConversionError("a number") from None
    if math.isnan(value):
        raise ConversionError("a number")
    return value


def text_of(is_right: Callable[[str], bool], expected: str) -> Callable[[yaml.Node], str]:
    """Converts to a text that is right.

    Args:
        is_right: tells whether a text is.
        expected: what an error says was expected.
    """

    def convert(node: yaml.Node) -> str:
        text = to_string(node)
        if not is_right(text):
            raise ConversionError(expected)
        return text

    return convert


def one_of(choices: Sequence[str]) -> Callable[[yaml.Node], str]:
    """Converts to one of some words."""

    def convert(node: yaml.Node) -> str:
        text = to_string(node)
        if text not in choices:
            words = " or ".join(filter(None, (", ".join(choices[:-1]), choices[-1])))
            raise ConversionError(f"{words}{suggestion(text, choices)}")
        return text

    return convert


def int_between(minimum: Optional[int], maximum: Optional[int]) -> Callable[[yaml.Node], int]:
    """Converts to a whole number between two bounds, which may be None for no bound."""

    def convert(node: yaml.Node) -> int:
        value = to_int(node)
        if minimum is not None and value < minimum:
            raise ConversionError(f"a whole number of {minimum} or more")
        if maximum is not None and value > maximum:
            raise ConversionError(f"a whole number of {maximum} or less")
        return value

    return convert


def float_from(minimum: float, above: float, allow_infinity: bool) -> Callable[[yaml.Node], float]:
    """Converts to a number, at least `minimum` and larger than `above`; never NaN."""

    def convert(node: yaml.Node) -> float:
        value = to_float(node)
        if math.isinf(value):
            if not allow_infinity:
                raise ConversionError("a finite number")
        elif abs(value) > LARGEST:
            raise ConversionError(f"a number within {LARGEST:g} of zero")
        if value < minimum:
            raise ConversionError(f"a number of {minimum:g} or more")
        if value <= above:
            raise ConversionError(f"a number above {above:g}")
        return value

    return convert


def floats_between(
    length: int, expected: str, minimum: float = -math.inf, maximum: float = math.inf
) -> Callable[[yaml.Node], Tuple[float, ...]]:
    """Converts to a list of `length` finite numbers between two bounds, both included.

    Args:
        length: required length of the list.
        expected: what an error says was expected, such as "[x, y]".
        minimum: lower bound of each number.
        maximum: upper bound of each number.
    """

    def convert(node: yaml.Node) -> Tuple[float, ...]:
        if not isinstance(node, yaml.SequenceNode) or len(node.value) != length:
            raise ConversionError(expected)
        try:
            values = tuple(to_float(item) for item in node.value)
        except ConversionError:
            raise ConversionError(expected) from None
        if not all(math.isfinite(value) and minimum <= value <= maximum for value in values):
            raise ConversionError(expected)
        if not all(abs(value) <= LARGEST for value in values):
            raise ConversionError(f"{expected}, numbers within {LARGEST:g} of zero")
        return values

    return convert


def points(minimum: int, maximum: int) -> Callable[[yaml.Node], List[Tuple[float, float]]]:
    """Converts to a list of `minimum` to `maximum` points `[x, y]`."""
    to_point = floats_between(2, "[x, y]")

    def convert(node: yaml.Node) -> List[Tuple[float, float]]:
        items = node.value if isinstance(node, yaml.SequenceNode) else []
        if not minimum <= len(items) <= maximum:
            number = f"{minimum} or more" if maximum == sys.maxsize else f"{minimum} to {maximum}"
            raise ConversionError(f"a list of {number} points [x, y]")
        return cast(List[Tuple[float, float]], _entries(to_point, items))

    return convert


def rows(form: str) -> Callable[[yaml.Node], FloatArray]:
    """Converts to an array of rows such as `[x, y, radius]`, shape (n, 3) for that form."""
    length = form.count(",") + 1
    to_row = floats_between(length, form)

    def convert(node: yaml.Node) -> FloatArray:
        if isinstance(node, ArrayNode) and node.array.shape[1] == length:
            array = np.asarray(node.array, np.float64)
            if (np.abs(array) <= LARGEST).all():
                return array
        if not isinstance(node, yaml.SequenceNode):
            raise ConversionError(f"a list of {form}")
        return np.array(_entries(to_row, node.value), np.float64).reshape(-1, length)

    return convert


def outlines(node: yaml.Node) -> List[FloatArray]:
    """Lists of three or more points `[x, y]`, each as an array (k, 2)."""
    found = _entries(points(3, sys.maxsize), to_items(node))
    return [np.array(outline, np.float64) for outline in found]


def cells(node: yaml.Node) -> "np.ndarray[Any, Any]":
    """Rows of numbers or booleans, all of the same length: shape (height, width)."""
    if isinstance(node, ArrayNode):
        return cast("np.ndarray[Any, Any]", node.array)
    content = to_content(node)
    is_grid = isinstance(content, list) and all(isinstance(row, list) for row in content)
    if not is_grid or len({len(row) for row in content}) != 1:
        raise ConversionError("rows of the same length")
    array = np.array(content)
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise ConversionError("rows of numbers")
    return array


def _entries(convert: Callable[[yaml.Node], T], items: Sequence[yaml.Node]) -> List[T]:
    """The entries of a list; an error has the index of one."""
    found = []
    for index, item in enumerate(items):
        try:
            found.append(convert(item))
        except ConversionError as error:
            raise ConversionError(str(error), index) from None
    return found


def describe(node: yaml.Node, depth: int = 2) -> str:
    """A value as it is written, cut to a readable length; lists to the given depth."""
    if isinstance(node, yaml.ScalarNode):
        if is_null(node):
            return "nothing"
        is_string = node.tag == "tag:yaml.org,2002:str"
        text = f'"{node.value}"' if is_string else str(node.value)
    elif isinstance(node, ArrayNode):
        text = f"an array of shape {node.array.shape}"
    elif isinstance(node, yaml.SequenceNode):
        if depth == 0:
            return "a list"
        items = [describe(item, depth - 1) for item in node.value[:_MOST_ITEMS]]
        text = f"[{', '.join(items)}]"
        if len(node.value) > _MOST_ITEMS:
            text = f"{len(node.value)} entries: {text[:-1]}, ...]"
    else:
        return "a map"
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."

"""What a YAML node says, as text, truth or numbers, and how it looks to its author."""

import math
from typing import Tuple

import yaml

LARGEST = 1e9
"""What physics can reckon with in single precision."""

_INFINITE = {"inf", ".inf", "+inf", "+.inf"}
_TRUE = {"true", "yes", "on", "y"}
_FALSE = {"false", "no", "off", "n"}


class Unexpected(Exception):
    """What was expected; whoever catches it adds where, and what was found."""


def is_null(node: yaml.Node) -> bool:
    """Whether nothing is given."""
    return node.tag == "tag:yaml.org,2002:null"


def to_string(node: yaml.Node) -> str:
    """The text of a scalar, whatever YAML takes it for."""
    if not isinstance(node, yaml.ScalarNode):
        raise Unexpected("a text")
    return str(node.value)


def to_strings(node: yaml.Node) -> Tuple[str, ...]:
    """The texts of a list; a single text is a list of one."""
    items = node.value if isinstance(node, yaml.SequenceNode) else [node]
    return tuple(to_string(item) for item in items)


def to_bool(node: yaml.Node) -> bool:
    """True or false, in any of YAML's spellings."""
    text = to_string(node).lower()
    if text not in _TRUE | _FALSE:
        raise Unexpected("true or false")
    return text in _TRUE


def to_int(node: yaml.Node) -> int:
    """A whole number."""
    try:
        return int(to_string(node).replace("_", "?"))  # in Python, 1_0 is a number
    except ValueError:
        raise Unexpected("a whole number") from None


def to_float(node: yaml.Node) -> float:
    """A number or infinity, in YAML's spelling or Python's; not NaN."""
    text = node.value if isinstance(node, yaml.ScalarNode) else ""
    if text.lower() in _INFINITE:
        return math.inf
    if text.lower() in {"-inf", "-.inf"}:
        return -math.inf
    try:
        value = float(text.replace("_", "?"))
    except ValueError:
        raise Unexpected("a number") from None
    if math.isnan(value):
        raise Unexpected("a number")
    return value


def to_floats(node: yaml.Node, length: int, shown: str) -> Tuple[float, ...]:
    """A list of finite numbers; `shown` is what an error calls it."""
    if not isinstance(node, yaml.SequenceNode) or len(node.value) != length:
        raise Unexpected(shown)
    try:
        values = tuple(to_float(item) for item in node.value)
    except Unexpected:
        raise Unexpected(shown) from None
    if not all(abs(value) <= LARGEST for value in values):
        raise Unexpected(shown)
    return values


def describe(node: yaml.Node, depth: int = 2) -> str:
    """A value as its author would recognise it, cut to a readable length."""
    if isinstance(node, yaml.ScalarNode):
        if is_null(node):
            return "nothing"
        quoted = node.tag == "tag:yaml.org,2002:str"
        text = f'"{node.value}"' if quoted else str(node.value)
    elif isinstance(node, yaml.SequenceNode):
        if depth == 0:
            return "a list"
        text = "[" + ", ".join(describe(item, depth - 1) for item in node.value[:12]) + "]"
    else:
        return "a map"
    return text if len(text) <= 60 else text[:57] + "..."

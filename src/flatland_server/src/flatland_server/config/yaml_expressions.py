"""`$eval` expressions in YAML files: their functions `env` and `param`, their results as nodes."""

import logging
import os
import re
from typing import Any, Callable, List

import yaml

from flatland_server.config.lua import LuaError, LuaEvaluator
from flatland_server.config.yaml_map import error_at
from flatland_server.exceptions import shortened

logger = logging.getLogger(__name__)

_NUMBER = re.compile(r"-?(0|[1-9][0-9]{0,14})(\.[0-9]+)?")
_TAG = "tag:yaml.org,2002:"


class Expressions:
    """Evaluates the expressions of YAML files.

    Args:
        get_param: the value of a parameter, or the default: `get_param(path, default)`.
    """

    def __init__(self, get_param: Callable[[str, Any], Any]) -> None:
        self._get_param = get_param
        self.has_environment = True
        """True if expressions may read environment variables."""
        self._place = ""  # file and line of the expression that is being evaluated
        self._lua = LuaEvaluator({"env": self._env, "param": self._param})

    def evaluate(self, node: yaml.ScalarNode, code: str) -> yaml.Node:
        """The value of an expression, as a node at its place.

        Args:
            node: the node that the expression is written in.
            code: the expression.

        Raises:
            YamlError: the expression fails.
        """
        self._place = f"{node.start_mark.name}:{node.start_mark.line + 1}"
        try:
            return _to_node(self._lua.evaluate(code), node)
        except LuaError as error:
            problem, place = shortened(str(error), 120), shortened(code, 60)
            raise error_at(node, f"$eval: {problem}, in: {place}") from None

    def restart_time(self) -> None:
        """Restarts the time limit, which holds for the expressions of one file."""
        self._lua.restart_time()

    def restart_random(self) -> None:
        """Restarts math.random."""
        self._lua.restart_random()

    def close(self) -> None:
        """Ends the process that evaluates expressions."""
        self._lua.close()

    def _env(self, arguments: List[Any]) -> Any:
        """The function `env(name, default)`: an environment variable."""
        name = _name(arguments, "env")
        if not self.has_environment:
            raise LuaError("a text of a client cannot read environment variables")
        if name in os.environ:
            return _from_environment(os.environ[name])
        return self._default(arguments, f'the environment variable "{name}" is not set')

    def _param(self, arguments: List[Any]) -> Any:
        """The function `param(path, default)`: a ROS parameter."""
        path = _name(arguments, "param")
        missing = object()
        try:
            value = self._get_param(path, missing)
        except Exception as error:
            raise LuaError(f'the parameter "{path}" cannot be read: {error}') from None
        if value is not missing:
            return value
        return self._default(arguments, f'the parameter "{path}" is not set')

    def _default(self, arguments: List[Any], problem: str) -> Any:
        """The default among the arguments; without one, warns and returns the empty string."""
        if len(arguments) == 2:
            return arguments[1]
        logger.warning("%s: %s and has no default; a blank string is used", self._place, problem)
        return ""


def _name(arguments: List[Any], function: str) -> str:
    """The first argument of `env` or `param`."""
    if len(arguments) not in (1, 2) or not isinstance(arguments[0], str):
        raise LuaError(f"expected {function}(name) or {function}(name, default)")
    return arguments[0]


def _from_environment(text: str) -> Any:
    """A variable as a bool, number or string, so that `if env("FLAG") then` works in Lua."""
    if text in ("true", "false"):
        return text == "true"
    return float(text) if _NUMBER.fullmatch(text) else text  # 007 is a string


def _to_node(value: Any, origin: yaml.ScalarNode) -> yaml.Node:
    """The node of a value that an expression has returned, at the place of the expression."""
    marks = (origin.start_mark, origin.end_mark)
    if isinstance(value, dict):
        pairs = [(_to_node(key, origin), _to_node(item, origin)) for key, item in value.items()]
        return yaml.MappingNode(f"{_TAG}map", pairs, *marks)
    if isinstance(value, list):
        return yaml.SequenceNode(f"{_TAG}seq", [_to_node(v, origin) for v in value], *marks)
    if value is None:
        return yaml.ScalarNode(f"{_TAG}null", "", *marks)
    if isinstance(value, bool):
        return yaml.ScalarNode(f"{_TAG}bool", "true" if value else "false", *marks)
    if isinstance(value, str):
        return yaml.ScalarNode(f"{_TAG}str", value, *marks)
    if float(value).is_integer() and abs(value) < 2**53:
        return yaml.ScalarNode(f"{_TAG}int", str(int(value)), *marks)
    return yaml.ScalarNode(f"{_TAG}float", repr(value), *marks)

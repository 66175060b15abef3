"""`$eval` expressions in YAML files: their functions `env` and `param`."""

import hashlib
import os
import re
from typing import Any, Callable, Dict, List, Tuple

import yaml

from flatland_server.config.lua import LuaError, LuaEvaluator
from flatland_server.config.plain_nodes import node_at
from flatland_server.config.yaml_map import error_at, warn_once
from flatland_server.exceptions import shortened

_NUMBER = re.compile(r"-?(0|[1-9][0-9]{0,14})(\.[0-9]+)?")


class Expressions:
    """Evaluates the expressions of YAML files.

    Args:
        get_param: the value of a parameter, or the default: `get_param(path, default)`.

    Attributes:
        seed: of the world. Each expression has random numbers of its own, by the seed, its file and
            its text; equal ones in a file are numbered.
        lua: evaluates them.
    """

    def __init__(self, get_param: Callable[[str, Any], Any]) -> None:
        self.seed = 0
        self._get_param = get_param
        self._root = ""  # the file that was read first; its name does not matter
        self._counts: Dict[Tuple[str, str], int] = {}  # of equal expressions in each file
        self.has_environment = True
        """True if expressions may read environment variables."""
        self._place = ""  # file and line of the expression that is being evaluated
        self.lua = LuaEvaluator()

    def evaluate(self, node: yaml.ScalarNode, code: str) -> yaml.Node:
        """The value of an expression, as a node at its place.

        Args:
            node: the node that the expression is written in.
            code: the expression.

        Raises:
            YamlError: the expression fails.
        """
        self._place = f"{node.start_mark.name}:{node.start_mark.line + 1}"
        functions = {"env": self._env, "param": self._param}
        try:
            value = self.lua.evaluate(code, functions, self._seed_of(node, code))
        except LuaError as error:
            problem, place = shortened(str(error), 120), shortened(code, 60)
            raise error_at(node, f"$eval: {problem}, in: {place}") from None
        return node_at(value, node.start_mark)

    def _seed_of(self, node: yaml.ScalarNode, code: str) -> int:
        """The seed of math.random in an expression."""
        file = node.start_mark.name
        folder = os.path.dirname(self._root)
        name = "" if file in ("", self._root) else os.path.relpath(file, folder)
        number = self._counts[name, code] = self._counts.get((name, code), -1) + 1
        stream = repr((self.seed, name, code, number)).encode()
        return int.from_bytes(hashlib.blake2b(stream, digest_size=4).digest(), "big") >> 1

    def restart(self, root: str, has_environment: bool = True) -> None:
        """Begins a file with all that it includes: restarts its time limit and its random numbers.

        Args:
            root: path of the file.
            has_environment: whether expressions may read environment variables.
        """
        self._root, self.has_environment = root, has_environment
        self._counts.clear()
        self.lua.restart_time()

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
        warn_once(f"{self._place}: {problem} and has no default; a blank string is used")
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

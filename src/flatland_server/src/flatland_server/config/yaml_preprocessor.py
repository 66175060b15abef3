"""From a YAML file to one tree of nodes: `$include`, `$[include]` and `$eval` resolved.

A node keeps the file and line that it was written in (its `start_mark`), so that an error names the
right place whatever it was included from.
"""

import io
import logging
import os
import re
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import yaml

from flatland_server.config.lua import LuaError, LuaEvaluator
from flatland_server.exceptions import YamlError

logger = logging.getLogger(__name__)

_INCLUDE = "$include"
_INCLUDE_ALL = "$[include]"
_EVAL = "$eval"

_NUMBER = re.compile(r"-?(0|[1-9][0-9]{0,14})(\.[0-9]+)?")
_MAX_DEPTH = 100  # of maps and lists in each other
_MAX_ITEMS = 100_000  # of a list

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_TAG = "tag:yaml.org,2002:"


class YamlPreprocessor:
    """Reads YAML files, with the parameters that their expressions may ask for.

    Args:
        get_param: the value of a parameter, or the default: `get_param(path, default)`.
    """

    def __init__(
        self, get_param: Callable[[str, Any], Any] = lambda _path, default: default
    ) -> None:
        self._get_param = get_param
        self._included: Dict[Path, List[yaml.Node]] = {}  # by this `read`, each file once
        self._place = ""  # of the expression that is being evaluated
        self._lua = LuaEvaluator({"env": self._env, "param": self._param})

    def read(self, path: Path) -> yaml.Node:
        """The root of a file's only document.

        Raises:
            YamlError: it or a file that it includes is missing, unreadable, empty or not YAML; an
                include leads back to itself; an expression fails.
        """
        self._included.clear()
        documents = self._compose(path)
        if len(documents) > 1:
            mark = documents[1].start_mark
            raise YamlError(
                path, "expected one document, found another one", mark.line + 1, mark.column + 1
            )
        try:
            return self._resolve(documents[0], (path,), {})
        except RecursionError:
            raise YamlError(path, "is nested too deeply") from None

    def close(self) -> None:
        """Ends what evaluates expressions."""
        self._lua.close()

    def _compose(self, path: Path) -> List[yaml.Node]:
        """The documents of a file, as they are written."""
        try:
            text = path.read_bytes().decode("utf-8-sig")
            _check_depth(path, text)
            documents = list(yaml.compose_all(_named(text, path), Loader=_LOADER))
        except OSError as error:
            raise YamlError(path, f"cannot be read: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise YamlError(path, f"is not UTF-8 text: byte {error.start} is wrong") from None
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark
            line, column = (mark.line + 1, mark.column + 1) if mark else (None, None)
            problem = " ".join(part for part in (error.context, error.problem) if part)
            raise YamlError(path, f"is not valid YAML: {problem}", line, column) from None
        except (yaml.YAMLError, RecursionError, ValueError) as error:
            reason = str(error).splitlines()[0]
            raise YamlError(path, f"is not valid YAML: {reason}") from None
        if not documents or documents[0] is None:
            raise YamlError(path, "expected a map, found an empty file")
        return documents

    def _resolve(
        self, node: yaml.Node, files: Tuple[Path, ...], done: Dict[int, Optional[yaml.Node]]
    ) -> yaml.Node:
        """A node with all in it resolved.

        Args:
            node: as it is written.
            files: the file that it stands in, last, and those that include it.
            done: the results for nodes that aliases bring here again; None while under way.
        """
        if isinstance(node, yaml.ScalarNode):
            return self._resolve_scalar(node, files)
        if id(node) in done:
            before = done[id(node)]
            if before is None:
                raise _error(node, "contains itself")
            return before
        done[id(node)] = None
        result: yaml.Node
        if isinstance(node, yaml.SequenceNode):
            items: List[yaml.Node] = []
            for item in node.value:
                path = _directive(item, _INCLUDE_ALL)
                if path is None:
                    items.append(self._resolve(item, files, done))
                else:
                    items.extend(self._include(item, path, files))
                if len(items) > _MAX_ITEMS:
                    raise _error(item, f"expected a list of at most {_MAX_ITEMS}, found more")
            result = yaml.SequenceNode(node.tag, items, node.start_mark, node.end_mark)
        else:
            pairs = self._resolve_pairs(node, files, done)
            result = yaml.MappingNode(node.tag, pairs, node.start_mark, node.end_mark)
        done[id(node)] = result
        return result

    def _resolve_pairs(
        self, node: yaml.Node, files: Tuple[Path, ...], done: Dict[int, Optional[yaml.Node]]
    ) -> List[Tuple[yaml.Node, yaml.Node]]:
        """A mapping's pairs, with those of `<<: *defaults` that it does not give itself."""
        own: List[Tuple[yaml.Node, yaml.Node]] = []
        inherited: Dict[str, Tuple[yaml.Node, yaml.Node]] = {}
        for key, value in node.value:
            resolved = self._resolve(value, files, done)
            if key.tag != f"{_TAG}merge":
                own.append((key, resolved))
                continue
            sources = resolved.value if isinstance(resolved, yaml.SequenceNode) else [resolved]
            for source in sources:
                if not isinstance(source, yaml.MappingNode):
                    raise _error(value, "expected a map or a list of maps after <<")
                for pair in source.value:
                    if not isinstance(pair[0], yaml.ScalarNode):
                        raise _error(pair[0], "expected a string as a key")
                    inherited.setdefault(pair[0].value, pair)
        for key, _ in own:
            inherited.pop(key.value if isinstance(key, yaml.ScalarNode) else "", None)
        return [*inherited.values(), *own]

    def _resolve_scalar(self, node: yaml.ScalarNode, files: Tuple[Path, ...]) -> yaml.Node:
        path = _directive(node, _INCLUDE)
        if path is not None:
            documents = self._include(node, path, files)
            if len(documents) != 1:
                message = f"expected one document in {path}, found {len(documents)}"
                raise _error(node, f"{message}; {_INCLUDE_ALL} takes several")
            return documents[0]
        code = _directive(node, _EVAL)
        if code is None:
            return node
        self._place = f"{node.start_mark.name}:{node.start_mark.line + 1}"
        try:
            return _to_node(self._lua.evaluate(code), node)
        except LuaError as error:
            raise _error(node, f"$eval: {error}, in: {_one_line(code)}") from None

    def _include(self, node: yaml.Node, name: str, files: Tuple[Path, ...]) -> List[yaml.Node]:
        """The resolved documents of a file that a node includes."""
        path = files[-1].parent / name
        if not is_file(path):
            raise _error(node, f"there is no file {path}")
        if any(path.samefile(file) for file in files):
            raise _error(node, f"{path} includes itself")
        real = path.resolve()
        if real not in self._included:
            self._included[real] = [
                self._resolve(document, (*files, path), {}) for document in self._compose(path)
            ]
        return self._included[real]

    def _env(self, arguments: List[Any]) -> Any:
        name = _name(arguments, "env")
        if name in os.environ:
            return _typed(os.environ[name])
        return self._default(arguments, f'the environment variable "{name}" is not set')

    def _param(self, arguments: List[Any]) -> Any:
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
        if len(arguments) == 2:
            return arguments[1]
        logger.warning("%s: %s and has no default; a blank string is used", self._place, problem)
        return ""


def is_file(path: Path) -> bool:
    """Whether there is such a file; there is none of a name that no file can have."""
    try:
        return path.is_file()
    except OSError:
        return False


def _named(text: str, path: Path) -> io.StringIO:
    """A stream whose name appears in the nodes' marks."""
    stream = io.StringIO(text)
    stream.name = str(path)
    return stream


def _check_depth(path: Path, text: str) -> None:
    """Refuses what is nested so deeply that composing it would overflow the stack."""
    depth = 0
    for event in yaml.parse(_named(text, path), Loader=_LOADER):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > _MAX_DEPTH:
                mark = event.start_mark
                message = f"expected at most {_MAX_DEPTH} levels, found more"
                raise YamlError(path, message, mark.line + 1, mark.column + 1)
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1


def _directive(node: yaml.Node, keyword: str) -> Any:
    """What follows a keyword at the beginning of a scalar, or None."""
    if not isinstance(node, yaml.ScalarNode):
        return None
    text = node.value.lstrip()
    if not text.startswith(keyword):
        return None
    rest = text[len(keyword) :]
    return rest.strip() if rest[:1].isspace() else None


def _name(arguments: List[Any], function: str) -> str:
    if len(arguments) not in (1, 2) or not isinstance(arguments[0], str):
        raise LuaError(f"expected {function}(name) or {function}(name, default)")
    return arguments[0]


def _typed(text: str) -> Any:
    """A text of the environment as Lua should see it, so that `if env("FLAG") then` works."""
    if text in ("true", "false"):
        return text == "true"
    return float(text) if _NUMBER.fullmatch(text) else text  # 007 is no number but a name


def _to_node(value: Any, origin: yaml.ScalarNode) -> yaml.Node:
    """A value that an expression has returned, in the place of the expression."""
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


def _error(node: yaml.Node, message: str) -> YamlError:
    mark = node.start_mark
    return YamlError(Path(mark.name), message, mark.line + 1, mark.column + 1)


def _one_line(code: str) -> str:
    text = " ".join(code.split())
    return text if len(text) <= 60 else text[:57] + "..."

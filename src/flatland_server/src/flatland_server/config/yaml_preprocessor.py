"""Composes a YAML file to a tree of nodes, with `$include`, `$[include]` and `$eval` resolved.

A node keeps the file and line that it is written in (its `start_mark`), so that errors name that
place, also in a file that is included.
"""

import io
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import yaml

from flatland_server.config.file_names import to_path
from flatland_server.config.input_files import MAX_YAML, is_file, read_input
from flatland_server.config.yaml_expressions import Expressions
from flatland_server.config.yaml_map import error_at
from flatland_server.config.yaml_values import is_null
from flatland_server.exceptions import FlatlandError, YamlError, shortened

_INCLUDE = "$include"
_INCLUDE_ALL = "$[include]"
_EVAL = "$eval"

_MAX_DEPTH = 100  # of nested maps and lists
_MAX_ITEMS = 100_000  # of a list
_MAX_VALUES = 1_000_000  # keys and values of a file with all that it includes: half a gigabyte

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_MERGE_TAG = "tag:yaml.org,2002:merge"


class YamlPreprocessor:
    """Reads YAML files, and resolves the includes and expressions in them.

    Args:
        get_param: for expressions, the value of a parameter: `get_param(path, default)`.
    """

    def __init__(
        self, get_param: Callable[[str, Any], Any] = lambda _path, default: default
    ) -> None:
        self._expressions = Expressions(get_param)
        self._included: Dict[Path, List[yaml.Node]] = {}  # by the current `read`, each file once
        self._value_count = 0  # of the current `read`

    def read(self, path: Path) -> yaml.Node:
        """The root node of a file, which must consist of one document.

        Raises:
            YamlError: it or a file that it includes is missing, unreadable, empty or not YAML; an
                include leads back to itself; an expression fails.
        """
        self._included.clear()
        self._value_count = 0
        self._expressions.restart_time()
        documents = self._compose(path)
        if len(documents) > 1:
            raise error_at(documents[1], "expected one document, found another one")
        try:
            return self._resolve(documents[0], (path,), {})
        except RecursionError:
            raise YamlError(path, "is nested too deeply") from None

    def resolve(self, node: yaml.Node) -> yaml.Node:
        """A copy of a node that was not read from a file, with everything resolved.

        Raises:
            YamlError: an expression fails, or a file that it includes is wrong.
        """
        self._included.clear()
        self._value_count = 0
        self._expressions.restart_time()
        return self._resolve(node, (Path(node.start_mark.name),), {})

    def restart_random(self) -> None:
        """Restarts math.random in expressions, as in a new preprocessor."""
        self._expressions.restart_random()

    def close(self) -> None:
        """Ends the process that evaluates expressions."""
        self._expressions.close()

    def _compose(self, path: Path) -> List[yaml.Node]:
        """The documents of a file, without anything resolved."""
        content = read_input(path, MAX_YAML)
        try:
            text = content.decode("utf-8-sig")
            self._check_structure(path, text)
            documents = list(yaml.compose_all(_named(text, path), Loader=_LOADER))
        except UnicodeDecodeError as error:
            raise YamlError(path, f"is not UTF-8 text: byte {error.start} is wrong") from None
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark
            line, column = (mark.line + 1, mark.column + 1) if mark else (None, None)
            problem = shortened(" ".join(part for part in (error.context, error.problem) if part))
            if mark and text[mark.index : mark.index + 1] == "\t":  # the parser does not name it
                problem = "lines are indented by spaces, found a tab"
            raise YamlError(path, f"is not valid YAML: {problem}", line, column) from None
        except (yaml.YAMLError, RecursionError, ValueError) as error:
            reason = shortened(str(error).splitlines()[0])
            raise YamlError(path, f"is not valid YAML: {reason}") from None
        if not documents or documents[0] is None:
            raise YamlError(path, "expected a map, found an empty file")
        if len(documents) > 1 and _is_empty(documents[-1]):
            documents.pop()  # nothing follows the last `---`
        return documents

    def _check_structure(self, path: Path, text: str) -> None:
        """Refuses text that is nested too deeply for the stack, or has too many values."""
        depth = 0
        for event in yaml.parse(_named(text, path), Loader=_LOADER):
            if isinstance(event, yaml.NodeEvent):
                self._value_count += 1
            if isinstance(event, yaml.CollectionStartEvent):
                depth += 1
            elif isinstance(event, yaml.CollectionEndEvent):
                depth -= 1
            problem = ""
            if depth > _MAX_DEPTH:
                problem = f"expected at most {_MAX_DEPTH} levels, found more"
            elif self._value_count > _MAX_VALUES:
                problem = f"expected at most {_MAX_VALUES} keys and values, found more"
            if problem:
                mark = event.start_mark
                raise YamlError(path, problem, mark.line + 1, mark.column + 1)

    def _resolve(
        self, node: yaml.Node, files: Tuple[Path, ...], done: Dict[int, Optional[yaml.Node]]
    ) -> yaml.Node:
        """A copy of a node in which everything is resolved.

        Args:
            node: as it is written.
            files: the files that include each other down to the one that the node is written in.
            done: the results by the `id` of the node, for aliases; None while a node is resolved.
        """
        if isinstance(node, yaml.ScalarNode):
            return self._resolve_scalar(node, files)
        if id(node) in done:
            before = done[id(node)]
            if before is None:
                raise error_at(node, "contains itself")
            return before
        done[id(node)] = None
        result: yaml.Node
        if isinstance(node, yaml.SequenceNode):
            items = self._resolve_items(node, files, done)
            result = yaml.SequenceNode(node.tag, items, node.start_mark, node.end_mark)
        else:
            pairs = self._resolve_pairs(node, files, done)
            result = yaml.MappingNode(node.tag, pairs, node.start_mark, node.end_mark)
        done[id(node)] = result
        return result

    def _resolve_items(
        self, node: yaml.Node, files: Tuple[Path, ...], done: Dict[int, Optional[yaml.Node]]
    ) -> List[yaml.Node]:
        """The items of a list, with those of each file that `$[include]` inserts."""
        items: List[yaml.Node] = []
        for item in node.value:
            path = _directive(item, _INCLUDE_ALL)
            if path is None:
                items.append(self._resolve(item, files, done))
            else:
                items.extend(self._include(item, path, files))
            if len(items) > _MAX_ITEMS:
                raise error_at(item, f"expected a list of at most {_MAX_ITEMS}, found more")
        return items

    def _resolve_pairs(
        self, node: yaml.Node, files: Tuple[Path, ...], done: Dict[int, Optional[yaml.Node]]
    ) -> List[Tuple[yaml.Node, yaml.Node]]:
        """A mapping's keys and values, and those of `<<: *defaults` for keys that it lacks."""
        own: List[Tuple[yaml.Node, yaml.Node]] = []
        inherited: Dict[str, Tuple[yaml.Node, yaml.Node]] = {}
        for key, value in node.value:
            resolved = self._resolve(value, files, done)
            if key.tag != _MERGE_TAG:
                own.append((key, resolved))
                continue
            sources = resolved.value if isinstance(resolved, yaml.SequenceNode) else [resolved]
            for source in sources:
                if not isinstance(source, yaml.MappingNode):
                    raise error_at(value, "expected a map or a list of maps after <<")
                for pair in source.value:
                    if not isinstance(pair[0], yaml.ScalarNode):
                        raise error_at(pair[0], "expected a string as a key")
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
                raise error_at(node, f"{message}; {_INCLUDE_ALL} takes several")
            return documents[0]
        code = _directive(node, _EVAL)
        if code is None:
            return node
        return self._expressions.evaluate(node, code)

    def _include(self, node: yaml.Node, name: str, files: Tuple[Path, ...]) -> List[yaml.Node]:
        """The resolved documents of a file that a node includes."""
        try:
            path = files[-1].parent / to_path(name)
        except FlatlandError as error:
            raise error_at(node, str(error)) from None
        if not is_file(path):
            raise error_at(node, f"there is no file {path}")
        if any(file.exists() and path.samefile(file) for file in files):
            raise error_at(node, f"{path} includes itself")
        real = path.resolve()
        if real not in self._included:
            self._included[real] = [
                self._resolve(document, (*files, path), {}) for document in self._compose(path)
            ]
        return self._included[real]


def _named(text: str, path: Path) -> io.StringIO:
    """A stream with a name, which PyYAML puts into the marks of nodes."""
    stream = io.StringIO(text)
    stream.name = str(path)
    return stream


def _is_empty(document: yaml.Node) -> bool:
    """Whether nothing is written in a document, not even `null`."""
    return isinstance(document, yaml.ScalarNode) and is_null(document) and not document.value


def _directive(node: yaml.Node, keyword: str) -> Any:
    """The text after a keyword at the beginning of a scalar, or None without the keyword."""
    if not isinstance(node, yaml.ScalarNode):
        return None
    text = node.value.lstrip()
    if not text.startswith(keyword):
        return None
    rest = text[len(keyword) :]
    return rest.strip() if rest[:1].isspace() else None

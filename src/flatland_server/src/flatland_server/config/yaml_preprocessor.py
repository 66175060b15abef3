"""Composes a YAML file to a tree of nodes, with `$include`, `$[include]` and `$eval` resolved.

A node keeps the file and line that it is written in (its `start_mark`), so that errors name that
place, also in a file that is included.
"""

from itertools import chain
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import yaml

from flatland_server.config.composed_files import (
    MAX_DEPTH,
    MAX_ITEMS,
    MAX_VALUES,
    ComposedFile,
    compose_file,
    compose_text,
)
from flatland_server.config.file_names import to_path
from flatland_server.config.input_files import is_file, similar_file
from flatland_server.config.plain_nodes import ArrayNode
from flatland_server.config.yaml_expressions import Expressions
from flatland_server.config.yaml_map import error_at
from flatland_server.exceptions import FlatlandError, YamlError

_INCLUDE = "$include"
_INCLUDE_ALL = "$[include]"
_EVAL = "$eval"

_MERGE_TAG = "tag:yaml.org,2002:merge"


class YamlPreprocessor:
    """Reads YAML files, and resolves the includes and expressions in them.

    The process that evaluates expressions ends with this object.

    Args:
        get_param: for expressions, the value of a parameter: `get_param(path, default)`.
        seed: seed of the world, for math.random in expressions.
    """

    def __init__(
        self, get_param: Callable[[str, Any], Any] = lambda _path, default: default, seed: int = 0
    ) -> None:
        self._get_param = get_param
        self._expressions = Expressions(get_param)
        self.seed = seed
        self._composed: Dict[Path, ComposedFile] = {}  # the files as they were read last
        self._reads_again = False
        self._included: Dict[Path, List[yaml.Node]] = {}  # by the current `read`, each file once
        self._value_count = 0  # of the current `read`

    def read(self, path: Path) -> yaml.Node:
        """The root node of a file, which must consist of one document.

        Raises:
            YamlError: it or a file that it includes is missing, unreadable, empty or not YAML; an
                include leads back to itself; an expression fails; it has too many values, each
                use of an alias and of an included file counted.
        """
        self._restart(path)
        return self._resolve_root(self._compose(path), path, (path,))

    def read_text(self, text: str, name: Path) -> yaml.Node:
        """The root node of a text, which must consist of one document.

        A text may come from a client, to which the content of files and the environment stay
        hidden: it includes no files, and its expressions read no environment variables.

        Args:
            text: YAML.
            name: stands for the file in errors.

        Raises:
            YamlError: it is empty or not YAML, or includes a file; an expression fails.
        """
        self._restart(name, has_environment=False)
        return self._resolve_root(compose_text(text, name), name, ())

    def resolve(self, node: yaml.Node) -> yaml.Node:
        """A copy of a node that was not read from a file, with everything resolved.

        Raises:
            YamlError: an expression fails, or a file that it includes is wrong.
        """
        self._restart(Path(node.start_mark.name))
        return self._resolve(node, (Path(node.start_mark.name),), {})

    def _restart(self, root: Path, has_environment: bool = True) -> None:
        self._included.clear()
        self._value_count = 0
        self._expressions.seed = self.seed
        self._expressions.restart(str(root), has_environment)

    @property
    def random_count(self) -> int:
        """The number of expressions so far that have called math.random, and so need the seed."""
        return self._expressions.lua.random_count

    def again(self, seed: int) -> "YamlPreprocessor":
        """A preprocessor for the same files, as this one has read them, with another seed."""
        other = YamlPreprocessor(self._get_param, seed)
        other._composed.update(self._composed)
        other._reads_again = True
        return other

    def is_plain(self, path: Path) -> bool:
        """True if a file that was read has no expressions and includes no other."""
        return path in self._composed and self._composed[path].is_plain

    def _compose(self, path: Path) -> ComposedFile:
        """A file as it is written; its values count for the limit of the current `read`."""
        composed = self._composed.get(path) if self._reads_again else None
        composed = composed or compose_file(path, self._value_count)
        self._composed[path] = composed
        self._value_count += composed.value_count
        return composed

    def _resolve_root(
        self, composed: ComposedFile, path: Path, files: Tuple[Path, ...]
    ) -> yaml.Node:
        if len(composed.documents) > 1:
            raise error_at(composed.documents[1], "expected one document, found another one")
        try:
            [root] = self._resolve_file(composed, files)
            if not composed.is_plain:  # else it has been measured as text
                _measure(root, {})
            return root
        except RecursionError:
            raise YamlError(path, "is nested too deeply") from None

    def _resolve_file(self, composed: ComposedFile, files: Tuple[Path, ...]) -> List[yaml.Node]:
        """The documents of a file with everything resolved."""
        if composed.is_plain:
            return list(composed.documents)
        return [self._resolve(document, files, {}) for document in composed.documents]

    def _resolve(
        self, node: yaml.Node, files: Tuple[Path, ...], done: Dict[int, Optional[yaml.Node]]
    ) -> yaml.Node:
        """A copy of a node in which everything is resolved.

        Args:
            node: node as it is written in the file.
            files: the files that include each other down to the one that the node is written in;
                none for a text.
            done: the results by the `id` of the node, for aliases; None while a node is resolved.
        """
        if isinstance(node, ArrayNode):
            return node
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
            if len(items) > MAX_ITEMS:
                raise error_at(item, f"expected a list of at most {MAX_ITEMS}, found more")
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
        if not files:
            raise error_at(node, "a text of a client cannot include files")
        try:
            path = files[-1].parent / to_path(name)
        except FlatlandError as error:
            raise error_at(node, str(error)) from None
        if not is_file(path):
            raise error_at(node, f"there is no file {path}{similar_file(path)}")
        if any(file.exists() and path.samefile(file) for file in files):
            raise error_at(node, f"{path} includes itself")
        real = path.resolve()
        if real not in self._included:
            self._included[real] = self._resolve_file(self._compose(path), (*files, path))
        return self._included[real]


def _directive(node: yaml.Node, keyword: str) -> Any:
    """The text after a keyword at the beginning of a scalar, or None without the keyword.

    A space follows a keyword; `$eval(1 + 2)` is an expression, too.
    """
    if not isinstance(node, yaml.ScalarNode):
        return None
    text = node.value.lstrip()
    if not text.startswith(keyword):
        return None
    rest = text[len(keyword) :]
    is_apart = rest[:1].isspace() or (keyword == _EVAL and rest.startswith("("))
    return rest.strip() if is_apart else None


def _measure(node: yaml.Node, known: Dict[int, Tuple[int, int]]) -> Tuple[int, int]:
    """The number of keys and values in a node, each use of an alias counted, and the depth.

    Args:
        node: node with everything resolved.
        known: the results for lists and maps by their `id`: each is measured once.

    Raises:
        YamlError: they are too many, or too deep.
    """
    if isinstance(node, yaml.ScalarNode):
        return 1, 0
    if id(node) not in known:
        inner = node.value if isinstance(node, yaml.SequenceNode) else chain(*node.value)
        count, depth = 1, 1
        for each in inner:
            more, levels = _measure(each, known)
            count, depth = count + more, max(depth, 1 + levels)
            if count > MAX_VALUES:
                expected = f"expected at most {MAX_VALUES} keys and values"
                raise error_at(each, f"{expected}, each use of an alias counted; found more")
            if depth > MAX_DEPTH:
                raise error_at(each, f"expected at most {MAX_DEPTH} levels, found more")
        known[id(node)] = count, depth
    return known[id(node)]

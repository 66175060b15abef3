"""Composes YAML files to trees of nodes, as they are written.

The trees of small files are kept: a file that has not changed, such as that of a model that is
spawned again, is not parsed again.
"""

import io
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, Tuple, Union

import yaml

from flatland_server.config.input_files import MAX_YAML, read_input, too_large
from flatland_server.config.syntax_errors import syntax_error
from flatland_server.config.yaml_map import error_at, warn_once
from flatland_server.config.yaml_values import is_null
from flatland_server.exceptions import YamlError, shortened

MAX_ITEMS = 100_000  # of a list
MAX_VALUES = 1_000_000  # keys and values of a file with all that it includes: half a gigabyte
MAX_DEPTH = 100  # of nested maps and lists
_MAX_KEPT = 20_000  # bytes of a file that is kept; its tree takes five megabytes at most

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class ComposedFile(NamedTuple):
    """The documents of a file. Their nodes are shared by all readers and must not be changed."""

    documents: Tuple[yaml.Node, ...]
    value_count: int
    """The number of its keys and values, maps and lists."""
    is_plain: bool
    """True if it has no directives (`$include`, `$eval`), no aliases, no tags and no `<<`."""
    content: bytes
    """The file's bytes."""


def compose_file(path: Path, count_before: int = 0) -> ComposedFile:
    """Composes a file.

    Args:
        path: path of the YAML file.
        count_before: the number of values in other files, counted towards the same limit.

    Raises:
        YamlError: it is missing, unreadable, empty, not YAML, nested too deeply or too large.
    """
    return _composed(path, read_input(path, MAX_YAML), count_before)


def compose_text(text: str, name: Path) -> ComposedFile:
    """Composes a text, with the limits of a file.

    Args:
        text: YAML.
        name: name that stands for the file in errors.

    Raises:
        YamlError: it is empty, not YAML, nested too deeply or too large.
    """
    content = text.encode(errors="surrogatepass")
    if len(content) > MAX_YAML:
        raise YamlError(name, too_large(MAX_YAML))
    return _composed(name, content, 0)


def _composed(path: Path, content: bytes, count_before: int) -> ComposedFile:
    compose = _compose if len(content) > _MAX_KEPT else _kept
    return compose(path, content, count_before)


def _compose(path: Path, content: bytes, count_before: int) -> ComposedFile:
    try:
        text = content.decode("utf-8-sig")
        value_count, is_plain = _checked_structure(path, text, count_before)
        documents = list(yaml.compose_all(_named(text, path), Loader=_LOADER))
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        found = f"found the byte 0x{error.object[error.start]:02X}"
        raise YamlError(path, f"is not UTF-8 text: {found}", line) from None
    except yaml.MarkedYAMLError as error:
        raise syntax_error(path, text, error) from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        reason = shortened(str(error).splitlines()[0])
        raise YamlError(path, f"is not valid YAML: {reason}") from None
    if not documents or documents[0] is None:
        raise YamlError(path, "expected a map, found an empty file")
    if len(documents) > 1 and _is_empty(documents[-1]):
        documents.pop()  # nothing follows the last `---`
    return ComposedFile(tuple(documents), value_count, is_plain, content)


_kept = lru_cache(maxsize=16)(_compose)


def _checked_structure(path: Path, text: str, count_before: int) -> Tuple[int, bool]:
    """The number of values in a text, and whether it is plain; see `ComposedFile`.

    Raises:
        YamlError: it is nested too deeply for the stack, or has too many values.
    """
    depth, count, is_plain = 0, 0, True
    for event in yaml.parse(_named(text, path), Loader=_LOADER):
        if isinstance(event, yaml.ScalarEvent):
            if event.tag or event.anchor or "$" in event.value or event.value == "<<":
                _warn_of_tag(event)
                is_plain = False
        elif isinstance(event, yaml.CollectionStartEvent):
            if event.tag or event.anchor:
                _warn_of_tag(event)
                is_plain = False
            depth += 1
            if depth > MAX_DEPTH:
                raise error_at(event, f"expected at most {MAX_DEPTH} levels, found more")
        elif isinstance(event, yaml.AliasEvent):
            is_plain = False
        else:
            if isinstance(event, yaml.CollectionEndEvent):
                depth -= 1
            continue
        count += 1
        if count_before + count > MAX_VALUES:
            problem = f"expected at most {MAX_VALUES} keys and values, found more"
            raise error_at(event, problem)
    return count, is_plain and count <= MAX_ITEMS


def _warn_of_tag(event: Union[yaml.ScalarEvent, yaml.CollectionStartEvent]) -> None:
    """Warns of a tag that is none of YAML's own, such as `!degrees`."""
    tag = event.tag or "!"
    if tag.startswith("!") and tag != "!":
        warn_once(str(error_at(event, f'the tag "{shortened(tag, 40)}" is ignored')))


def _named(text: str, path: Path) -> io.StringIO:
    """A stream with a name, which PyYAML puts into the marks of nodes."""
    stream = io.StringIO(text)
    stream.name = str(path)
    return stream


def _is_empty(document: yaml.Node) -> bool:
    """True if nothing is written in a document, not even `null`."""
    return isinstance(document, yaml.ScalarNode) and is_null(document) and not document.value

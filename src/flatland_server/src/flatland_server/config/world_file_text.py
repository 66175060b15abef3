"""Changes of the models in a world file's text; every other byte of it stays.

YAML libraries that write what they have read, such as ruamel.yaml, indent lists anew, and join
those of several lines. So the places are taken from PyYAML's marks, and only they are replaced.
"""

import json
import re
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Optional, Set, Tuple

import yaml

from flatland_server.config.composed_files import compose_file
from flatland_server.config.yaml_map import error_at
from flatland_server.exceptions import FlatlandError

PoseValues = Tuple[float, float, float]

_ALIAS = re.compile(r"\*[^\s,\[\]{}]+")
_AFTER_KEY = re.compile(r"\s*:")
_LINE = re.compile(r"[^\n]*")
_FILE_KEYS = {"layers": "map", "models": "model"}
"""Keys of the entries of these lists that name files."""
_INCLUDE = re.compile(r"\s*\$(?:include|\[include\])\s+(.+)")


class NewEntry(NamedTuple):
    """An entry to add."""

    name: str
    namespace: str
    model: str
    """The name of its file."""
    pose: PoseValues


class WorldFileText:
    """A world file's text, and the places of its entries.

    Args:
        path: the file's path.
        root: its content with everything resolved, as `YamlPreprocessor.read` gives it.

    Raises:
        YamlError: it cannot be read.
    """

    def __init__(self, path: Path, root: yaml.Node) -> None:
        composed = compose_file(path)
        self._text = composed.content.decode("utf-8-sig")
        self._mark = b"\xef\xbb\xbf" if composed.content.startswith(b"\xef\xbb\xbf") else b""
        self._line_end = "\r\n" if "\r\n" in self._text else "\n"
        self._root: Any = composed.documents[0]
        self._list: Any = _value(self._root, "models")  # None without one
        self._resolved = {
            name: node for node in _items(_value(root, "models")) for name in _enabled_name(node)
        }
        self._changes: List[Tuple[int, int, str]] = []  # begin, end, what is put there

    @property
    def content(self) -> bytes:
        """The file as it has been changed. What is within an entry that is removed goes with it."""
        parts, place = [], 0
        for begin, end, new in sorted(self._changes):
            if begin >= place:
                parts += [self._text[place:begin], new]
                place = end
        return self._mark + "".join([*parts, self._text[place:]]).encode()

    def change_models(
        self,
        poses: Mapping[str, Tuple[PoseValues, PoseValues]],
        deleted: List[str],
        added: List[NewEntry],
    ) -> None:
        """Changes entries of `models`.

        Args:
            poses: the former and the new pose of models, by name.
            deleted: names of models.
            added: entries to append to the list.

        Raises:
            YamlError: an entry is not written in this file.
        """
        for name, (former, pose) in poses.items():
            self._move(self._entry(name), former, pose)
        gone = {id(self._entry(name)) for name in deleted}
        if gone or added:
            self._change_list(gone, added)

    def name_files_from(self, folder: Path) -> None:
        """Writes names of files in the text's folder as absolute paths.

        Args:
            folder: folder of the file from which the text was read.
        """
        for node, match in _file_names(self._root):
            name = match[1].strip()
            file = folder / name
            if not name.startswith(("/", "~", "$", "package:")) and file.exists():
                begin, end = node.start_mark.index, node.end_mark.index
                written = _scalar(node.value.replace(name, str(file.resolve())))
                self._changes.append((begin, end, written))

    def _entry(self, name: str) -> Any:
        """The entry of a model, as it is written."""
        resolved = self._resolved.get(name)
        if resolved is None:
            raise FlatlandError(f'the file has no model "{name}" any more')
        for node in _items(self._list):
            is_entry = isinstance(node, yaml.MappingNode) and self._is_here(node)
            if is_entry and _place(node) == _place(resolved):
                return node
        raise error_at(resolved, f'the model "{name}" is written here: change it by hand')

    def _is_here(self, node: yaml.Node) -> bool:
        """False for an alias of something that is written outside of the list."""
        begin: int = self._list.start_mark.index
        return begin <= node.start_mark.index <= int(self._list.end_mark.index)

    # Poses

    def _move(self, entry: Any, former: PoseValues, pose: PoseValues) -> None:
        for key, value in entry.value:
            if key.value == "pose":
                self._replace_pose(key, value, former, pose)
                return
        end = self._end(entry, entry.start_mark.index)
        if entry.flow_style:
            self._changes.append((end - 1, end - 1, f", pose: {_list(pose)}"))
        else:
            column = " " * entry.value[0][0].start_mark.column
            end = self._line_end_after(end)
            self._changes.append((end, end, f"{self._line_end}{column}pose: {_list(pose)}"))

    def _replace_pose(
        self, key: yaml.Node, value: yaml.Node, former: PoseValues, pose: PoseValues
    ) -> None:
        begin, end = self._span(value, key.end_mark.index)
        is_own = begin == value.start_mark.index
        if is_own and isinstance(value, yaml.SequenceNode) and len(value.value) == 3:
            for item, before, now in zip(value.value, former, pose):
                first, last = self._span(item, begin)
                begin = last
                if before != now:
                    self._changes.append((first, last, _number(now)))
        else:
            self._changes.append((begin, end, _list(pose)))

    # Entries

    def _change_list(self, gone: Set[int], added: List[NewEntry]) -> None:
        key = next((key for key, _ in _pairs(self._root) if key.value == "models"), None)
        if key is None:
            self._add_key(added)
            return
        if isinstance(self._list, yaml.ScalarNode) and self._list.value not in ("", "null", "~"):
            raise error_at(self._list, "models come from another file: change them there")
        items = _items(self._list)
        kept = [item for item in items if id(item) not in gone]
        begin, end = self._span(self._list, key.end_mark.index)
        if not items:
            self._changes.append((begin, end, self._new_list(added, bool(self._root.flow_style))))
        elif self._list.flow_style:
            self._rewrite_flow_list(items, kept, added, begin, end)
        elif not kept and not added:
            colon = _AFTER_KEY.match(self._text, key.end_mark.index)
            assert colon is not None
            self._changes.append((colon.end(), colon.end(), " []"))
            self._remove_lines(items, gone)
        else:
            self._remove_lines(items, gone)
            self._add_lines(items[-1], added)

    def _remove_lines(self, items: List[yaml.Node], gone: Set[int]) -> None:
        for item in items:
            if id(item) in gone:
                dash = self._dash(item)
                begin = self._text.rfind("\n", 0, dash) + 1
                end = self._line_end_after(self._end(item, item.start_mark.index))
                self._changes.append((begin, min(end + len(self._line_end), len(self._text)), ""))

    def _add_lines(self, last: yaml.Node, added: List[NewEntry]) -> None:
        if not added:
            return
        dash = self._dash(last)
        column = dash - (self._text.rfind("\n", 0, dash) + 1)
        is_flow = bool(getattr(last, "flow_style", False))
        end = self._line_end_after(self._end(last, last.start_mark.index))
        place = min(end + len(self._line_end), len(self._text))
        lines = "".join(
            _block(entry, column, is_flow, self._line_end) + self._line_end for entry in added
        )
        if place == end:  # the last line has no end
            lines = self._line_end + lines
        self._changes.append((place, place, lines))

    def _rewrite_flow_list(
        self,
        items: List[yaml.Node],
        kept: List[yaml.Node],
        added: List[NewEntry],
        begin: int,
        end: int,
    ) -> None:
        new = [_flow(entry) for entry in added]
        if not kept:
            self._changes.append((begin, end, f"[{', '.join(new)}]"))
            return
        spans = [self._span(item, begin) for item in items]
        first = items.index(kept[0])
        self._changes.append((spans[0][0], spans[first][0], ""))
        for item, (_, before), (_, last) in zip(
            items[first + 1 :], spans[first:], spans[first + 1 :]
        ):
            if item not in kept:
                self._changes.append((before, last, ""))
        last = spans[-1][1]
        self._changes.append((last, last, "".join(f", {each}" for each in new)))

    def _add_key(self, added: List[NewEntry]) -> None:
        end = self._end(self._root, 0)
        if self._root.flow_style:
            self._changes.append((end - 1, end - 1, f', "models": {self._new_list(added, True)}'))
            return
        end = self._line_end_after(end)
        line = f"{self._line_end}models:{self._new_list(added, False)}"
        self._changes.append((end, end, line))

    def _new_list(self, added: List[NewEntry], is_flow: bool) -> str:
        if is_flow:
            return f"[{', '.join(map(_flow, added))}]"
        entries = (_block(entry, 2, False, self._line_end) for entry in added)
        return "".join(f"{self._line_end}{entry}" for entry in entries)

    # Places

    def _dash(self, item: yaml.Node) -> int:
        return self._text.rindex("-", 0, item.start_mark.index)

    def _line_end_after(self, index: int) -> int:
        match = _LINE.match(self._text, index)
        assert match is not None
        return match.end() - int(match[0].endswith("\r"))

    def _span(self, node: yaml.Node, after: int) -> Tuple[int, int]:
        """Begin and end of a node, or of an alias of it, that is written after an index."""
        if node.start_mark.index < after:  # the mark is that of the anchor, which comes before
            alias = _ALIAS.search(self._text, after)
            if alias is None:
                raise error_at(node, "is not written where it is used")
            return alias.span()
        return node.start_mark.index, self._end(node, after)

    def _end(self, node: Any, after: int) -> int:
        """The end of a node without the comments and blank lines after it."""
        if node.start_mark.index < after:
            return self._span(node, after)[1]
        end: int = node.end_mark.index
        if isinstance(node, yaml.ScalarNode) or node.flow_style:
            while end > node.start_mark.index and self._text[end - 1].isspace():
                end -= 1
            return end
        place: int = node.start_mark.index
        children = node.value
        if isinstance(node, yaml.MappingNode):
            children = [each for pair in node.value for each in pair]
        for child in children:
            place = self._end(child, place)
        return place


def _place(node: yaml.Node) -> Tuple[str, int]:
    return node.start_mark.name, node.start_mark.index


def _pairs(node: Optional[yaml.Node]) -> List[Tuple[yaml.Node, yaml.Node]]:
    return node.value if isinstance(node, yaml.MappingNode) else []


def _items(node: Optional[yaml.Node]) -> List[yaml.Node]:
    return node.value if isinstance(node, yaml.SequenceNode) else []


def _value(node: Optional[yaml.Node], name: str) -> Optional[yaml.Node]:
    return next((value for key, value in _pairs(node) if key.value == name), None)


def _enabled_name(entry: yaml.Node) -> Iterator[str]:
    """The name of an entry, if it is enabled."""
    values: Dict[str, str] = {
        key.value: value.value for key, value in _pairs(entry) if isinstance(value, yaml.ScalarNode)
    }
    if "name" in values and values.get("enabled", "true").lower() not in ("false", "no", "off"):
        yield values["name"]


def _file_names(node: yaml.Node, key: str = "") -> Iterator[Tuple[yaml.Node, "re.Match[str]"]]:
    """The scalars of a world that name files, each with a match; its first group is the name."""
    if isinstance(node, yaml.ScalarNode):
        match = _INCLUDE.fullmatch(node.value)
        if match:
            yield node, match
        return
    for name, value in _pairs(node):
        is_name = isinstance(value, yaml.ScalarNode) and name.value == _FILE_KEYS.get(key)
        match = re.fullmatch(r"([^$].*)", value.value) if is_name else None
        if match:
            yield value, match
        else:
            yield from _file_names(value, name.value)
    for item in _items(node):
        yield from _file_names(item, key)


def _number(value: float) -> str:
    return repr(value + 0.0)  # no negative zero


def _list(pose: PoseValues) -> str:
    return f"[{', '.join(map(_number, pose))}]"


def _scalar(text: str) -> str:
    """A string in YAML, quoted if it has to be, also between brackets."""
    try:
        is_plain = yaml.safe_load(f"[{text}]") == [text]
    except yaml.YAMLError:
        is_plain = False
    return text if is_plain else json.dumps(text, ensure_ascii=False)


def _values(entry: NewEntry) -> List[Tuple[str, str]]:
    values = [("name", _scalar(entry.name))]
    if entry.namespace:
        values.append(("namespace", _scalar(entry.namespace)))
    return [*values, ("model", _scalar(entry.model)), ("pose", _list(entry.pose))]


def _flow(entry: NewEntry) -> str:
    return "{" + ", ".join(f"{key}: {value}" for key, value in _values(entry)) + "}"


def _block(entry: NewEntry, column: int, is_flow: bool, line_end: str) -> str:
    """An item of a block list, without the end of its last line."""
    if is_flow:
        return f"{' ' * column}- {_flow(entry)}"
    lines = [f"{key}: {value}" for key, value in _values(entry)]
    return f"{' ' * column}- " + f"{line_end}{' ' * (column + 2)}".join(lines)

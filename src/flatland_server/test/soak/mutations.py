"""Spoils files: wrong types, lost and doubled keys, extreme numbers, nesting, cuts, binary data."""

import copy
import math
import random
from pathlib import Path
from typing import Any, Callable, List, Tuple

import yaml

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)

NUMBERS = (
    *(0, -1, 1, 2, -0.0, 2**31, 2**63, -(2**63), 10**40, 1e6, 1e300, -1e300, 1e-300, 5e-324, 1e38),
    *(math.nan, math.inf, -math.inf, 0.1 + 0.2, 1e-9, 65536, 100_000_000),
)
ODD = (
    *(None, True, False, "", " ", "all", "none", "a b", "1.0", "1e3", "0x10", "1_000", "12:30"),
    *("nan", ".inf", "true", "~", "/", "..", ".", "/dev/null", "/proc/self/mem", "no.yaml"),
    *("base", "robot", "map", "walls", "dynamic", "static", "circle", "polygon", "\u2028", "\x00"),
    *("x" * 5000, "ü", "\U0001f600", "!!python/object:os.system", "a/b", "//", "-", "*", "&a"),
    *([], {}, [[]], [{}], [1], [1, 2], [1, 2, 3], [0, 0, 0, 0], {"a": 1}, {1: 2}, {None: None}),
    *([[0, 0], [1, 0], [0, 1]], [[0, 0], [1, 1], [2, 2]], [[0, 0]] * 9, [0] * 2000),
    *("$include no.yaml", "$include world.yaml", "$include .", "$[include] world.yaml", "$include"),
    *("$eval 1 +", "$eval nil", "$eval {1, 2}", "$eval 1/0", "$eval -(0/0)", "$eval error('x')"),
    *("$eval env('HOME', 1)", "$eval param('/x', 2)", "$eval string.rep('x', 1e9)", "$eval {a={}}"),
    *("$eval function() end", "$eval #'abc'", "$eval os.exit()", "$[include] rails.yaml"),
)  # fmt: skip
LINES = (
    *("models:", "bodies: []", "plugins: {}", "  - ", "a: *a", "b: &b [*b]", "<<: {x: 1}", "---"),
    *("? [a, b]", "x: !!binary aGk=", "y: !foo bar", "...", "\t- tab", "%YAML 9.9", "# only", "}"),
    *("z: |", "name: robot", "$[include]: world.yaml", "- $[include] world.yaml", "k: {" * 500),
    *("n: " + "[" * 200 + "]" * 200, "m: &m {a: 1}", "s: 'open", 'q: "\\x"', "l: [1, 2", "@", "`"),
)  # fmt: skip
LAUGHS = "\n".join(
    ["a0: &a0 [x, x, x, x, x, x, x, x]"]
    + [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 8)}]" for i in range(1, 9)]
)
"""8 to the power of 9 strings, by aliases of aliases."""

Place = Tuple[Any, ...]


class Mutator:
    """Spoils the contents of files at random."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._tree: List[Callable[[Any, Place], None]] = [
            self._replace, self._replace, self._replace, self._delete, self._rename, self._scale,
            self._stringify, self._duplicate, self._copy, self._nest,
        ]  # fmt: skip
        self._text: List[Callable[[bytes], bytes]] = [
            self._double_line, self._drop_line, self._insert_line, self._indent, self._cut,
            self._binary, self._flip, self._laughs,
        ]  # fmt: skip

    def spoil(self, path: Path) -> None:
        """Changes a file one to four times."""
        content = path.read_bytes()
        is_yaml = path.suffix == ".yaml"
        for _ in range(self._rng.choice([1, 1, 2, 4])):
            if is_yaml and self._rng.random() < 0.7:
                content = self._spoil_tree(content)
            else:
                content = self._rng.choice(self._text)(content)
        path.write_bytes(content)

    # Values

    def spoil_data(self, document: Any) -> None:
        """Changes a value in maps and lists."""
        self._rng.choice(self._tree)(document, self._rng.choice(_places(document)))

    def _spoil_tree(self, content: bytes) -> bytes:
        try:
            document = yaml.load(content, Loader=_LOADER)
            places = _places(document)
        except (yaml.YAMLError, ValueError, RecursionError, TypeError):
            return content  # spoilt before
        if not places or len(places) > 5000:
            return content
        try:
            self.spoil_data(document)
            return yaml.dump(document, Dumper=_DUMPER, sort_keys=False, allow_unicode=True).encode()
        except RecursionError:  # nested too deeply for PyYAML, after several changes
            return content

    def _odd(self) -> Any:
        return copy.deepcopy(self._rng.choice(self._rng.choice([NUMBERS, ODD])))

    def _replace(self, document: Any, place: Place) -> None:
        _parent(document, place)[place[-1]] = self._odd()

    def _delete(self, document: Any, place: Place) -> None:
        del _parent(document, place)[place[-1]]

    def _rename(self, document: Any, place: Place) -> None:
        parent = _parent(document, place)
        if isinstance(parent, dict):
            key = self._rng.choice([f"{place[-1]}x", str(place[-1])[1:], 7, "name", None, "type"])
            parent[key] = parent.pop(place[-1])

    def _scale(self, document: Any, place: Place) -> None:
        parent, key = _parent(document, place), place[-1]
        if isinstance(parent[key], (int, float)):
            parent[key] *= self._rng.choice([-1, 0, 1e-30, 1e-4, 1000.0, 1e30])

    def _stringify(self, document: Any, place: Place) -> None:
        parent, key = _parent(document, place), place[-1]
        parent[key] = self._rng.choice([str, repr, lambda v: [v], lambda v: {"value": v}])(
            parent[key]
        )

    def _duplicate(self, document: Any, place: Place) -> None:
        parent = _parent(document, place)
        if isinstance(parent, list):
            parent.extend([parent[place[-1]]] * self._rng.choice([1, 1, 30]))  # an alias in YAML

    def _copy(self, document: Any, place: Place) -> None:
        source = self._rng.choice(list(_places(document)))
        value = copy.deepcopy(_parent(document, source)[source[-1]])
        _parent(document, place)[place[-1]] = value

    def _nest(self, document: Any, place: Place) -> None:
        parent, key = _parent(document, place), place[-1]
        for _ in range(self._rng.choice([1, 3, 90, 150])):
            parent[key] = [parent[key]] if self._rng.random() < 0.5 else {"a": parent[key]}

    # Text

    def _double_line(self, content: bytes) -> bytes:
        lines = content.splitlines(keepends=True) or [b""]
        at = self._rng.randrange(len(lines))
        return b"".join([*lines[: at + 1], lines[at], *lines[at + 1 :]])

    def _drop_line(self, content: bytes) -> bytes:
        lines = content.splitlines(keepends=True) or [b""]
        del lines[self._rng.randrange(len(lines))]
        return b"".join(lines)

    def _insert_line(self, content: bytes) -> bytes:
        lines = content.splitlines(keepends=True)
        line = self._rng.choice(["", "  ", "    "]) + self._rng.choice(LINES) + "\n"
        lines.insert(self._rng.randrange(len(lines) + 1), line.encode())
        return b"".join(lines)

    def _indent(self, content: bytes) -> bytes:
        lines = content.splitlines(keepends=True) or [b""]
        at = self._rng.randrange(len(lines))
        lines[at] = self._rng.choice([b"  " + lines[at], lines[at].lstrip(b" "), lines[at][1:]])
        return b"".join(lines)

    def _cut(self, content: bytes) -> bytes:
        return content[: self._rng.randrange(len(content) + 1)]

    def _binary(self, content: bytes) -> bytes:
        at = self._rng.randrange(len(content) + 1)
        return content[:at] + self._rng.choice(
            [bytes(range(256)), b"\x00" * 10, b"\xff\xfe", b"\xef\xbb\xbf", b"\x1b[31m", b"\r"]
        ) + content[at:]  # fmt: skip

    def _flip(self, content: bytes) -> bytes:
        changed = bytearray(content)
        for _ in range(self._rng.randint(1, 8)):
            if changed:
                changed[self._rng.randrange(len(changed))] = self._rng.randrange(256)
        return bytes(changed)

    def _laughs(self, content: bytes) -> bytes:
        return content + b"\n" + LAUGHS.encode() + b"\n"


def _places(node: Any, path: Place = ()) -> List[Place]:
    """The paths to all values in maps and lists."""
    if not isinstance(node, (dict, list)) or len(path) > 100:
        return []
    items = list(node.items()) if isinstance(node, dict) else list(enumerate(node))
    found = [(*path, key) for key, _ in items]
    for key, value in items:
        if len(found) < 5000:  # aliases of aliases are many
            found += _places(value, (*path, key))
    return found


def _parent(document: Any, place: Place) -> Any:
    for key in place[:-1]:
        document = document[key]
    return document

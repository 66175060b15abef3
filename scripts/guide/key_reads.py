"""The keys of world, model and map files, observed from the getter calls of their readers.

The readers of worlds, models, maps and plugins run on samples while their getters are observed. So
a key, its type, its bounds and its default have one source: the line of code that reads it.
"""

import contextlib
import functools
import inspect
import math
import re
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Sequence, Set, Tuple

from flatland_server import REQUIRED, ModelPlugin, YamlReader
from flatland_server.plugins.plugin import Plugin

GETTERS = [name for name in dir(YamlReader) if name.startswith("get_")]
PLUGIN_GETTERS = {
    ModelPlugin: ("get_body", "get_body_names", "get_joint"),
    Plugin: ("get_frame_id",),
}
WITHOUT_DEFAULT = {"get_path": REQUIRED, "get_joint": REQUIRED, "get_body_names": ()}
"""Defaults of getters that have no such argument."""
CONTAINERS = ("get_section", "get_sections", "get_enabled_sections")


class Read(NamedTuple):
    """One call of a getter."""

    place: Tuple[str, str]
    """The file's name, and the path of the map in it, such as `models[]`."""
    key: str
    getter: str
    default: Any
    options: Dict[str, Any]
    """The getter's other arguments."""
    conditional: bool
    """True if `has` was asked first: the key may be missing though there is no default."""


class Key(NamedTuple):
    """A key that a map may have."""

    name: str
    type: str
    unit: str
    """The unit of values of this type; empty if there is none."""
    default: str
    """The default as YAML, "**required**" or "none"; empty if it depends on other keys."""


class Observation:
    """The calls of getters while samples are read."""

    def __init__(self) -> None:
        self.reads: List[Read] = []
        self.asked: Set[Tuple[Tuple[str, str], str]] = set()
        """Keys that `has` was asked for: they may be missing."""

    def keys(self, file: str, path: str) -> List[Key]:
        """The keys of a map and of the maps within it, in the order in which they are read."""
        found: Dict[str, List[Read]] = {}
        for read in self.reads:
            name, place = read.place
            inner = place[len(path) :]
            if name == file and place.startswith(path) and (not path or inner[:1] in ".["):
                found.setdefault(f"{inner}.{read.key}".lstrip("."), []).append(read)
        return [_merge(name, reads) for name, reads in found.items()]

    def defaults(self, file: str, path: str) -> Dict[str, Any]:
        """The defaults of the keys of a map and of the maps within it, by their paths."""
        found = {}
        for read in self.reads:
            (name, place), key = read.place, read.key
            inner = place[len(path) :]
            if name == file and place.startswith(path) and "[" not in inner:
                is_value = read.getter not in CONTAINERS and read.default is not REQUIRED
                if is_value and key not in ("type", "name", "enabled"):
                    is_tuple = isinstance(read.default, tuple)
                    default = list(read.default) if is_tuple else read.default
                    found[f"{inner}.{key}".lstrip(".")] = default
        return found


@contextlib.contextmanager
def observed() -> Iterator[Observation]:
    """Records all getter calls in its context."""
    observation = Observation()
    depth = 0
    originals: List[Tuple[type, str, Any]] = []

    def watch(owner: type, name: str) -> None:
        method = getattr(owner, name)
        signature = inspect.signature(method)

        @functools.wraps(method)
        def getter(self: Any, *args: Any, **options: Any) -> Any:
            nonlocal depth
            bound = signature.bind(self, *args, **options)
            bound.apply_defaults()
            values = dict(bound.arguments)
            reader = values.pop("config", None) or values["self"]
            is_container = name in CONTAINERS
            if depth == 0 and not (is_container and _is_inner(observation, reader, values["key"])):
                asked = (_place(reader), values["key"]) in observation.asked
                observation.reads.append(_read(name, reader, values, asked))
            depth += not is_container
            try:
                return method(self, *args, **options)
            finally:
                depth -= not is_container

        originals.append((owner, name, vars(owner)[name]))
        setattr(owner, name, getter)

    for name in GETTERS:
        watch(YamlReader, name)
    for owner, names in PLUGIN_GETTERS.items():
        for name in names:
            watch(owner, name)
    has = YamlReader.has

    def note_has(self: YamlReader, key: str) -> bool:
        if depth == 0:
            observation.asked.add((_place(self), key))
        return has(self, key)

    YamlReader.has = note_has  # type: ignore[method-assign]
    try:
        yield observation
    finally:
        del YamlReader.has  # the inherited one
        for owner, name, original in originals:
            setattr(owner, name, original)


def _is_inner(observation: Observation, reader: YamlReader, key: str) -> bool:
    """True if another getter makes this call for the same key, which is recorded already."""
    last = observation.reads[-1] if observation.reads else None
    return last is not None and last.place == _place(reader) and last.key == key


def _read(getter: str, reader: YamlReader, values: Dict[str, Any], conditional: bool) -> Read:
    values.pop("self")
    key = values.pop("key")
    default = values.pop("default", WITHOUT_DEFAULT.get(getter))
    if getter in CONTAINERS:
        empty: Any = {} if getter == "get_section" else []
        default = REQUIRED if values.pop("required") else empty
    return Read(_place(reader), key, getter, default, values, conditional)


def _place(reader: YamlReader) -> Tuple[str, str]:
    return Path(reader._root).name, re.sub(r"\[\d+\]", "[]", reader.path)


def _merge(name: str, reads: Sequence[Read]) -> Key:
    """The description of a key, from all getter calls for it in all samples."""
    types = list(dict.fromkeys(_type(read) for read in reads))
    if len(types) > 1 and "string" in types:
        types.remove("string")  # a check of the type, before the getter that reads the value
    types.sort(key="map".__eq__)
    units = [_UNITS[read.getter] for read in reads if read.getter in _UNITS]
    defaults = list(dict.fromkeys(_yaml(r.default) for r in reads if r.default is not REQUIRED))
    required = [read for read in reads if read.default is REQUIRED]
    if any(not read.conditional for read in required):
        default = "**required**"
    elif required and defaults in ([], ['""']):
        default = "none"
    else:
        default = defaults[0] if len(defaults) == 1 else ""
    return Key(name, " or ".join(types), units[0] if units else "", default)


_MAX_CHOICES = 8
"""The largest number of choices listed in a table cell."""

_UNITS = {"get_rate": "Hz", "get_pose": "m, m, rad", "get_point": "m", "get_points": "m"}


def _type(read: Read) -> str:
    options = read.options
    simple: Dict[str, str] = {
        "get_string": "string",
        "get_topic": "topic",
        "get_frame": "frame",
        "get_name": "name",
        "get_frame_id": "frame",
        "get_rate": "> 0, or `inf`",
        "get_bool": "boolean",
        "get_pose": "`[x, y, yaw]`",
        "get_point": "`[x, y]`",
        "get_color": "`[r, g, b, alpha]`",
        "get_strings": "string or list",
        "get_path": "file",
        "get_section": "map",
        "get_sections": "list of maps",
        "get_enabled_sections": "list of maps",
        "get_body": "body",
        "get_body_names": "list of bodies",
        "get_joint": "joint",
    }
    if read.getter in simple:
        return simple[read.getter]
    special: Dict[str, Callable[[], str]] = {
        "get_float": lambda: _bounds(options).lstrip(" ,") or "number",
        "get_int": lambda: f"whole number{_bounds(options)}",
        "get_choice": lambda: _choice(options["choices"]),
        "get_floats": lambda: f"{options['length']} numbers{_bounds(options)}",
        "get_points": lambda: f"{_span(options)} points `[x, y]`",
    }
    return special[read.getter]()


def _span(options: Dict[str, Any]) -> str:
    counts = (options["minimum"], options["maximum"])
    return " to ".join(map(str, sorted(set(counts))))


def _choice(words: Sequence[str]) -> str:
    if len(words) > _MAX_CHOICES:
        return f"one of {len(words)} words"
    return ", ".join(f"`{word}`" for word in words)


def _bounds(options: Dict[str, Any]) -> str:
    minimum, maximum, above = (options.get(name) for name in ("minimum", "maximum", "above"))
    if above is not None and above > -math.inf:
        return f" > {above:g}"
    if minimum is not None and maximum is not None:
        return f", {minimum} to {maximum}"
    if minimum is not None and minimum > -math.inf:
        return f" ≥ {minimum:g}"
    return ""


def _yaml(value: Any) -> str:
    """A default as it would be written in a file, or "none"."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return f"{value:g}"
    if isinstance(value, str):
        return value or '""'
    if isinstance(value, dict):
        return "{}"
    return f"[{', '.join(map(_yaml, value))}]"

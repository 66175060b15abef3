"""Checks of the names of topics and frames. Each yields the problems that it finds."""

from typing import Any, Callable, Iterator, List, Tuple

from flatland_server.testing.checked_plugin import (
    CheckedPlugin,
    Document,
    KeyPath,
    Names,
    key_name,
    keys_of,
    value_at,
    with_value,
)

Problems = Iterator[str]
Rename = Callable[[str], str]

SECONDS = 0.5
"""The duration of simulations [s]."""

_NAMESPACE = "robot1"
_PREFIX = "renamed_"
_WORLD_FRAME_KEYS = ("odom_frame_id", "ground_truth_frame_id", "world_frame_id")
_WORLD_FRAMES = ("odom", "map")
"""Frames that belong to no model: the defaults of these keys, and values without a "~"."""


def check_names(case: CheckedPlugin) -> Problems:
    """Topics and frames are as the entry says, with the namespace before them once."""
    names = _names(case, case.entry, "")
    yield from _check_renamed(case, names)
    if not case.is_of_world:
        yield from _check_namespace(case, names)


def _check_renamed(case: CheckedPlugin, names: Names) -> Problems:
    """Other names in the entry change those of topics and frames."""
    topics, frames = _topic_keys(case, names), _frame_keys(case, names)
    entry = case.entry
    for path in [*topics, *frames]:
        entry = with_value(entry, path, f"{_PREFIX}{value_at(case.entry, path).lstrip('/')}")
    old_topics = {_absolute(value_at(case.entry, path)) for path in topics}
    old_frames = {value_at(case.entry, path) for path in frames}

    def topic(name: str) -> str:
        return f"/{_PREFIX}{name[1:]}" if name in old_topics else name

    def frame(name: str) -> str:
        return f"{_PREFIX}{name}" if name in old_frames else name

    found = _names(case, entry, "")
    yield from _compare("renamed", _renamed(names, topic, frame), found)


def _check_namespace(case: CheckedPlugin, names: Names) -> Problems:
    """The namespace is before relative topics and the model's frames; and nowhere else."""
    values = [value_at(case.entry, path) for path in keys_of(case.entry)]
    outside = {v for v in values if isinstance(v, str) and v.startswith("/")}
    given = {str(case.entry.get(key)) for key in _WORLD_FRAME_KEYS}
    own = {each[1:] for each in given if each.startswith("~")}
    world_frames = (given | set(_WORLD_FRAMES)) - own

    def topic(name: str) -> str:
        return name if name in outside else f"/{_NAMESPACE}{name}"

    def frame(name: str) -> str:
        return name if name in world_frames else f"{_NAMESPACE}_{name}"

    label = f'in the namespace "{_NAMESPACE}"'
    found = _names(case, case.entry, _NAMESPACE)
    yield from _compare(label, _renamed(names, topic, frame), found)

    entry = case.entry
    for path in _topic_keys(case, names):
        name = _absolute(value_at(case.entry, path))
        entry = with_value(entry, path, name)
        outside.add(name)
    found = _names(case, entry, _NAMESPACE)
    yield from _compare(f"{label}, topics absolute", _renamed(names, topic, frame), found)


def _names(case: CheckedPlugin, entry: Document, namespace: str) -> Names:
    return case.load(entry, namespace=namespace).go(SECONDS).names


def _topic_keys(case: CheckedPlugin, names: Names) -> List[KeyPath]:
    """The keys of an entry that have topics as values."""
    topics = {*names.published, *names.subscribed}
    return [path for path, value in _texts(case) if _absolute(value) in topics]


def _frame_keys(case: CheckedPlugin, names: Names) -> List[KeyPath]:
    """The keys of an entry that have frames as values."""
    frames = {frame for edge in names.transforms for frame in edge}
    frames |= {frame for _, frame in names.message_frames}
    return [path for path, value in _texts(case) if value in frames and "frame" in key_name(path)]


def _texts(case: CheckedPlugin) -> Iterator[Tuple[KeyPath, str]]:
    """The keys with strings as values, and these strings."""
    for path in keys_of(case.entry):
        value = value_at(case.entry, path)
        if isinstance(value, str):
            yield path, value


def _absolute(topic: str) -> str:
    return f"/{topic.lstrip('/')}"


def _renamed(names: Names, topic: Rename, frame: Rename) -> Names:
    return Names(
        tuple(sorted(map(topic, names.published))),
        tuple(sorted(map(topic, names.subscribed))),
        tuple(sorted((frame(a), frame(b)) for a, b in names.transforms)),
        tuple(sorted((topic(a), frame(b)) for a, b in names.message_frames)),
    )


def _compare(label: str, expected: Names, found: Names) -> Problems:
    for field, a, b in zip(Names._fields, expected, found):
        if a != b:
            yield f"{label}: expected {field.replace('_', ' ')} {_listed(a)}, found {_listed(b)}"


def _listed(names: Tuple[Any, ...]) -> str:
    words = [" ".join(each) if isinstance(each, tuple) else each for each in names]
    return ", ".join(words) or "none"

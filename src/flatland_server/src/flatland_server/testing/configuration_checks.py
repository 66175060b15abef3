"""Checks of the keys and values that a plugin reads and refuses. Each yields problems."""

import re
from typing import Any, Iterator, List

from flatland_server.testing.checked_plugin import (
    CheckedPlugin,
    KeyPath,
    key_name,
    keys_of,
    value_at,
    with_key,
    with_value,
    without,
)

Problems = Iterator[str]

_RATE_KEYS = re.compile(r"(^|_)rate$")
_NAMES_NO_PART = re.compile(r"frame|topic|_pub$|_sub$")
"""Keys that do not name a body or joint, even if there is one named like the key's value."""


def check_keys(case: CheckedPlugin) -> Problems:
    """The entry has all keys that the plugin reads."""
    run = case.load()
    run.simulation.world.close()
    shown = {key_name(path) for path in keys_of(case.entry)}
    for key in sorted(run.loader.keys - shown):
        if key.rpartition(".")[2] not in case.other_keys:
            yield f'the plugin reads the key "{key}", which the entry does not show'


def check_unknown_keys(case: CheckedPlugin) -> Problems:
    """A misspelt key is refused, at any depth, with its line and a suggestion."""
    for path in keys_of(case.entry):
        key = str(path[-1])
        wrong = misspelt(key)
        entry = with_key(case.entry, path, wrong)
        expected = f'unknown key "{wrong}" (did you mean "{key}"?)'
        refusal = case.refusal(entry)
        line, _ = case.lines((*path[:-1], wrong))
        if not any(_is_at(case, line, each) and each.endswith(expected) for each in refusal):
            yield _expected(f'a refusal of "{wrong}" in line {line}: {expected}', refusal)


def check_missing_keys(case: CheckedPlugin) -> Problems:
    """Without a key the plugin is loaded, or refused because the key is missing."""
    for path in keys_of(case.entry):
        refusal = case.refusal(without(case.entry, path))
        expected = f'the required key "{path[-1]}" is missing'
        if refusal and not any(each.endswith(expected) for each in refusal):
            yield _expected(f'without "{key_name(path)}": {expected}', refusal)


def check_wrong_values(case: CheckedPlugin) -> Problems:
    """Values of a wrong type, NaN, rates of zero and unknown bodies are refused at their line."""
    parts = case.names_of_parts()
    for path in keys_of(case.entry):
        value = value_at(case.entry, path)
        wrong = wrong_values(value)
        if _RATE_KEYS.search(str(path[-1])):
            wrong += [0, -1, "nan"]
        if value in parts and not _NAMES_NO_PART.search(str(path[-1])):
            wrong.append(misspelt(value))
        for each in wrong:
            yield from _check_refused(case, path, each)


def _check_refused(case: CheckedPlugin, path: KeyPath, value: Any) -> Problems:
    entry = with_value(case.entry, path, value)
    place = re.compile(rf"plugins\[0\]\S*\.{re.escape(str(path[-1]))}[.:\[]")
    refusal = case.refusal(entry)
    key_line, value_line = case.lines(path)
    if not any(
        (_is_at(case, key_line, each) or _is_at(case, value_line, each)) and place.search(each)
        for each in refusal
    ):
        yield _expected(
            f'a refusal of "{key_name(path)}: {value}" that names the key and line {value_line}',
            refusal,
        )


def wrong_values(value: Any) -> List[Any]:
    """Values of which none can stand where `value` is right."""
    if isinstance(value, bool):
        return ["perhaps", {"a": 1}]
    if isinstance(value, (int, float)):
        return ["nan", "fast", [1], {"a": 1}]
    if value == "inf":  # a number, or a choice that may have "nan", too
        return ["fast", [1], {"a": 1}]
    if isinstance(value, str):
        return [{"a": 1}]
    if isinstance(value, list) and value and all(isinstance(each, (int, float)) for each in value):
        return [["nan", *value[1:]], value[:-1], "far", {"a": 1}]
    if isinstance(value, list):
        return [{"a": 1}]
    return [5] if isinstance(value, dict) else []


def misspelt(name: str) -> str:
    """A name with a mistake that is near enough to be recognised."""
    swapped = name[1:2] + name[:1] + name[2:]
    return swapped if len(name) > 2 and swapped != name else name + name[-1:]


def _is_at(case: CheckedPlugin, line: int, message: str) -> bool:
    return message.startswith(f"{case.file}:{line}: plugins[0]")


def _expected(what: str, refusal: List[str]) -> str:
    found = "\n    ".join(refusal) or "it is loaded"
    return f"expected {what}, found\n    {found}"

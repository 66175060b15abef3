"""The parameters of a sweep: their combinations, and what each of them changes.

A name says what a parameter is:

    /disc_radius                           `param("/disc_radius")` in the world's files
    controller.speed                       an argument of the controller
    models.robot.plugins.laser.range       a value in the world; entries of lists go by their names
"""

import json
from itertools import product
from math import prod
from typing import Any, Dict, List, Mapping, Sequence

from flatland_server.exceptions import UsageError, listed, shortened, suggestion

_CONTROLLER = "controller."


def count_combinations(grids: Sequence[Mapping[str, Any]]) -> int:
    """How many `combinations` there are."""
    return sum(
        prod(len(value) if isinstance(value, list) else 1 for value in grid.values())
        for grid in grids
    )


def combinations(grids: Sequence[Mapping[str, Any]]) -> List[Dict[str, Any]]:
    """Each combination of the values of each grid, in order, the last parameter changing fastest.

    Args:
        grids: lists of values, or single values, by the names of the parameters.
    """
    found: List[Dict[str, Any]] = []
    for grid in grids:
        values = [value if isinstance(value, list) else [value] for value in grid.values()]
        found.extend(dict(zip(grid, chosen)) for chosen in product(*values))
    return found


def world_params(parameters: Mapping[str, Any]) -> Dict[str, Any]:
    """Those for expressions in the world's files, by absolute name."""
    return {name: value for name, value in parameters.items() if name.startswith("/")}


def world_key(world: str, parameters: Mapping[str, Any]) -> str:
    """A key for a world as parameters change it: equal ones are equal worlds."""
    parts = [world, world_params(parameters), world_changes(parameters)]
    return json.dumps(parts, sort_keys=True)


def is_for_controller(name: str) -> bool:
    """Whether a parameter is an argument of the controller."""
    return name.startswith(_CONTROLLER)


def controller_arguments(parameters: Mapping[str, Any]) -> Dict[str, Any]:
    """Those for the controller, by the names of its arguments."""
    start = len(_CONTROLLER)
    return {n[start:]: value for n, value in parameters.items() if is_for_controller(n)}


def world_changes(parameters: Mapping[str, Any]) -> Dict[str, Any]:
    """Those that change values in the world, by their places."""
    return {n: value for n, value in parameters.items() if not n.startswith(("/", _CONTROLLER))}


def names_a_file(place: str) -> bool:
    """Whether the value at a place in a world may be a file: a layer's map, a model."""
    words = place.split(".")
    return len(words) == 3 and (words[0], words[2]) in (("layers", "map"), ("models", "model"))


def set_value(content: Dict[str, Any], place: str, value: Any) -> None:
    """Changes a value in a world.

    Args:
        content: of the world; see `world_content`.
        place: such as "models.robot.plugins.laser.range".
        value: the new one.

    Raises:
        UsageError: there is no such place.
    """
    *way, last = place.split(".")
    inner: Any = content
    for number, word in enumerate(way):
        inner = _inner(inner, word, place, ".".join(way[:number]))
    if isinstance(inner, list):
        inner[_index(inner, last, place, ".".join(way))] = value
    elif isinstance(inner, dict):
        inner[last] = value
    else:
        raise UsageError(f'the parameter "{place}": "{".".join(way)}" is no map and no list')


def _inner(outer: Any, word: str, place: str, where: str) -> Any:
    """The map or list of this name within another one; for a model, also within its `model`."""
    if isinstance(outer, list):
        return outer[_index(outer, word, place, where)]
    if isinstance(outer, dict):
        if word in outer:
            return outer[word]
        if isinstance(outer.get("model"), dict):
            return _inner(outer["model"], word, place, where)
    known = list(outer) if isinstance(outer, dict) else []
    raise _unknown(word, known, place, where)


def _index(entries: Sequence[Any], word: str, place: str, where: str) -> int:
    """The index of an entry of a list, by its name or its number."""
    names = [str(each.get("name")) if isinstance(each, dict) else "" for each in entries]
    if word in names:
        return names.index(word)
    if word.isdigit() and int(word) < len(entries):
        return int(word)
    raise _unknown(word, names, place, where)


def _unknown(word: str, known: Sequence[str], place: str, where: str) -> UsageError:
    inside = f' in "{where}"' if where else " in the world"
    return UsageError(
        f'the parameter "{place}": there is no "{shortened(word)}"{inside}'
        f"{suggestion(word, known)}; there are: {listed(known)}"
    )

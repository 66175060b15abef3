"""The parameters of a sweep: their combinations, and their effect on worlds.

The name of a parameter decides about its kind:

    /disc_radius                           `param("/disc_radius")` in the world's files
    controller.speed                       an argument of the controller
    models.robot.plugins.laser.range       a value in the world; entries of lists go by their names
"""

import json
from itertools import product
from math import prod
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence, Set

from flatland2d.world_source import read_world_content
from flatland_server.config import YamlPreprocessor, find_world, is_file, to_path
from flatland_server.exceptions import FlatlandError, UsageError, listed, shortened, suggestion
from flatland_server.transport import absolute_name

_CONTROLLER = "controller."


def count_combinations(grids: Sequence[Mapping[str, Any]]) -> int:
    """The number of `combinations`."""
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
    """Parameters for expressions in the world's files, by absolute name."""
    return {name: value for name, value in parameters.items() if name.startswith("/")}


def world_key(world: str, parameters: Mapping[str, Any]) -> str:
    """A key for a world changed by parameters: equal keys mean equal worlds."""
    parts = [world, world_params(parameters), world_changes(parameters)]
    return json.dumps(parts, sort_keys=True)


def is_for_controller(name: str) -> bool:
    """True if a parameter is an argument of the controller."""
    return name.startswith(_CONTROLLER)


def controller_arguments(parameters: Mapping[str, Any]) -> Dict[str, Any]:
    """Parameters for the controller, by the names of its arguments."""
    start = len(_CONTROLLER)
    return {n[start:]: value for n, value in parameters.items() if is_for_controller(n)}


def world_changes(parameters: Mapping[str, Any]) -> Dict[str, Any]:
    """Parameters that change values in the world, by their places."""
    return {n: value for n, value in parameters.items() if not n.startswith(("/", _CONTROLLER))}


def _names_a_file(place: str) -> bool:
    """True if the value at a place in a world may be a file: a layer's map, a model."""
    words = place.split(".")
    return len(words) == 3 and (words[0], words[2]) in (("layers", "map"), ("models", "model"))


def world_file(source: str, folder: Path) -> Path:
    """The file of a world.

    Args:
        source: its file or name, as it is written in the scenario file.
        folder: the scenario file's folder.

    Raises:
        FlatlandError: there is neither a file nor a shipped world of this name.
    """
    path = folder / to_path(source)
    if not is_file(path):
        path = folder / find_world(source)
        if not is_file(path):
            raise FlatlandError(f"expected a world file, but {path} is not there")
    return path


class SweepWorlds:
    """Reads worlds, each as one dict with its models.

    The process that evaluates expressions is kept: starting one takes longer than reading most
    worlds.

    Args:
        folder: of the scenario file, to which paths are relative.

    Attributes:
        preprocessor: of the world that was read last, with its parameters.
        params_read: the parameters that expressions in the files have read so far, by name.
        is_random: whether the content that was read last depends on the seed.
    """

    def __init__(self, folder: Path) -> None:
        self.preprocessor = YamlPreprocessor(self._get_param)
        self.params_read: Set[str] = set()
        self.is_random = False
        self._folder = folder
        self._params: Mapping[str, Any] = {}

    def content(self, source: str, parameters: Mapping[str, Any], seed: int = 0) -> Dict[str, Any]:
        """The content of a world changed by the parameters of a scenario: a new dict.

        Args:
            source: as it is written in the scenario file.
            parameters: a scenario's parameters.
            seed: of a scenario, for random numbers in expressions.

        Raises:
            FlatlandError: something in its files is wrong, or a parameter has no place in it.
        """
        self._params, self.preprocessor.seed = world_params(parameters), seed
        before = self.preprocessor.random_count
        content = read_world_content(world_file(source, self._folder), self.preprocessor)
        changes = world_changes(parameters)
        for place, value in changes.items():
            if _names_a_file(place) and isinstance(value, str):
                value = str(self._folder / to_path(value))
            set_value(content, place, value)
        if any(map(_names_a_file, changes)):
            # Again, with the new models and maps.
            content = read_world_content(content, self.preprocessor)
        self.is_random = self.preprocessor.random_count != before
        return content

    def _get_param(self, name: str, default: Any) -> Any:
        name = absolute_name(name)
        self.params_read.add(name)
        return self._params.get(name, default)


def set_value(content: Dict[str, Any], place: str, value: Any) -> None:
    """Changes a value in a world.

    Args:
        content: content of the world, which is changed; see `world_content`.
        place: such as "models.robot.plugins.laser.range".
        value: the new value.

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
    if word in map(str, range(len(entries))):
        return int(word)
    raise _unknown(word, names, place, where)


def _unknown(word: str, known: Sequence[str], place: str, where: str) -> UsageError:
    inside = f' in "{where}"' if where else " in the world"
    return UsageError(
        f'the parameter "{place}": there is no "{shortened(word)}"{inside}'
        f"{suggestion(word, known)}; there are: {listed(known)}"
    )

"""Numbers of model files that differ between the environments of a batch.

A number of a file may set several ones of the core: an `acceleration_limit` is the deceleration
limit, too, unless that is given. So worlds are loaded with other values of it, and compared with
the first one. The core's numbers that follow are those that each environment has for itself.
"""

import math
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from flatland2d.batch.robot import make_core, roles_of
from flatland2d.robot import Robot
from flatland_server import _core
from flatland_server.arguments import shown
from flatland_server.arrays import BoolArray, FloatArray, IntArray
from flatland_server.config import YamlReader
from flatland_server.exceptions import (
    FlatlandError,
    StateError,
    UsageError,
    listed,
    suggestion,
    unknown,
)
from flatland_server.models import ModelConfig
from flatland_server.plugins import plugin_rng
from flatland_server.simulation import World, WorldConfig

Ranges = Mapping[str, Tuple[float, float]]
"""The least and the greatest value of each number, by its name: MODEL/PLUGIN/KEY or MODEL/BODY/KEY,
with more keys for sections. A pattern such as `box_*` stands for all models that match and have the
plugin or body: they have one value."""

_LISTS = ("plugins", "bodies", "joints")


def ranges_of(value: Any, or_numbers: bool = False) -> Dict[str, Tuple[float, float]]:
    """Ranges that a program has passed.

    Args:
        value: the ranges by name.
        or_numbers: whether a number may stand for a range of only itself.

    Raises:
        UsageError: they are no pairs of numbers by name.
    """
    if not isinstance(value, Mapping):
        raise UsageError(f"expected vary as a dict of ranges by name, found {shown(value)}")
    ranges = {}
    for name, pair in value.items():
        if not isinstance(name, str) or name.count("/") < 2 or not all(name.split("/")):
            raise UsageError(f"expected names in vary as MODEL/PLUGIN/KEY, found {shown(name)}")
        ends = _array(pair)
        if or_numbers and ends.ndim == 0:
            ends = np.repeat(ends, 2)
        least, greatest = ends.tolist() if ends.shape == (2,) else (math.nan, math.nan)
        if not -math.inf < least <= greatest < math.inf:
            expected = f'expected vary["{name}"] as a pair (least, greatest) of numbers'
            also = ", or a number" if or_numbers else ""
            raise UsageError(f"{expected}{also}, found {shown(pair)}")
        ranges[name] = least, greatest
    return ranges


def _array(value: Any) -> FloatArray:
    """Numbers that a program has passed, as float64; empty if they are none."""
    try:
        array = np.asarray(value)
    except ValueError:  # lists of unequal lengths
        return np.zeros(0)
    return array.astype(np.float64) if array.dtype.kind in "fiu" else np.zeros(0)


def with_values(config: WorldConfig, values: Mapping[str, float]) -> WorldConfig:
    """A world as it would be with other numbers in its model files.

    Args:
        config: the world.
        values: the numbers, by names as in `Ranges`.

    Raises:
        UsageError: a name leads nowhere, or a model cannot have the number.
    """
    models = list(config.models)
    contents: Dict[int, Dict[str, Any]] = {}
    for name, value in values.items():
        pattern, entry, *keys = name.split("/")
        chosen = [k for k, each in enumerate(models) if fnmatchcase(each.name, pattern)]
        known = [each.name for each in models]
        if not chosen:
            raise UsageError(unknown("vary: there is no model", pattern, known))
        for k in chosen:
            if k not in contents:
                reader = models[k].model.reader
                assert reader is not None  # the models of a world are read
                contents[k] = reader.content()
        entries = [_entries(contents[k]) for k in chosen]
        if not any(entry in each for each in entries):
            raise UsageError(
                f'vary: "{name}" names no plugin, body or joint{suggestion(entry, entries[0])}; '
                f"the model has: {listed(list(entries[0]))}"
            )
        for each in entries:
            if entry in each:
                _set(each[entry], keys, float(value), name)
    for k, content in contents.items():
        former = models[k].model
        reader = YamlReader.from_content(content, f"vary, {models[k].name}")
        try:
            changed = ModelConfig.read(reader, config.registry)
        except FlatlandError as error:
            raise UsageError(str(error)) from error
        same = {name: getattr(former, name) for name in ("path", "content", "reader")}
        models[k] = replace(models[k], model=replace(changed, **same))  # as states know it
    return replace(config, models=tuple(models))


def _entries(content: Mapping[str, Any]) -> Dict[str, Any]:
    """The plugins, bodies and joints of a model, by name."""
    return {each["name"]: each for part in _LISTS for each in content.get(part) or ()}


def _set(node: Any, keys: Sequence[str], value: float, name: str) -> None:
    """Sets a number in a section; in a list, that of the entry with an index, or those of all."""
    key, *rest = keys
    is_index = key.isdecimal() and len(key) < 10
    if isinstance(node, list) and not is_index:
        for each in node:
            _set(each, keys, value, name)
        return
    place: Any = int(key) if isinstance(node, list) else key
    if not isinstance(node, (dict, list)) or (isinstance(node, list) and place >= len(node)):
        raise UsageError(f'vary: "{name}" leads to no number')
    if not rest:
        node[place] = value
    elif isinstance(node, dict):
        _set(node.setdefault(key, {}), rest, value, name)
    else:
        _set(node[place], rest, value, name)


class Variation:
    """The numbers that differ between environments, and their values in each.

    Args:
        config: the world of all environments.
        ranges: of the numbers; see `ranges_of`.
        count: number of environments, n.
        load: loads a world.
        robots: finds the robots of a world.

    Attributes:
        config: the world with the greatest values, which environments have at first.
        settings: the indices of the core's settings that vary.
        noises: settings of the noise of a robot's lidar in each environment, (n, 3), by the robot's
            index, where they vary.

    Raises:
        FlatlandError: a name or a range is wrong, or a number cannot differ.
    """

    def __init__(
        self,
        config: WorldConfig,
        ranges: Ranges,
        count: int,
        load: Callable[[WorldConfig], World],
        robots: Callable[[World], Sequence[Robot]],
    ) -> None:
        if ranges and config.with_seed is not None:
            raise UsageError("expected no vary with files that have random numbers")
        self._ranges = dict(ranges)
        self._names = list(ranges)
        self._original = config
        self._load, self._robots = load, robots
        self.config = with_values(config, {name: high for name, (_, high) in ranges.items()})
        self._values = np.tile([high for _, high in ranges.values()], (count, 1))
        self.settings: List[int] = []
        self._columns: List[int] = []  # the name of each of these settings
        self.noises: Dict[int, FloatArray] = {}
        self._noise_places: List[Tuple[int, int, int]] = []  # a name, a robot and a number of it
        if ranges:
            self._find(count)

    def __bool__(self) -> bool:
        return bool(self._ranges)

    def set(self, core: _core.WorldBatch, given: Any, mask: Optional[BoolArray]) -> FloatArray:
        """Gives environments other values.

        Args:
            core: of the batch.
            given: a number, or one for each environment (n,), by name.
            mask: which environments, (n,); None: all. Values of others do not count.

        Returns:
            The former values, for `put`.

        Raises:
            UsageError: a name or a value is wrong. Nothing has changed.
        """
        if not isinstance(given, Mapping):
            raise UsageError(f"expected vary as a dict of numbers by name, found {shown(given)}")
        values = self._values.copy()
        rows: Any = slice(None) if mask is None else mask
        for name, value in given.items():
            if name not in self._ranges:
                raise UsageError(unknown("vary: there is no", str(name), self._names))
            values[rows, self._names.index(name)] = self._checked(name, value, rows)
        return self.put(core, values)

    def _checked(self, name: str, value: Any, rows: Any) -> FloatArray:
        count = len(self._values)
        numbers = _array(value)
        if numbers.shape not in ((), (count,)):
            expected = f'expected vary["{name}"] as a number, or {count} of them'
            raise UsageError(f"{expected}, found {shown(value)}")
        chosen: FloatArray = np.broadcast_to(numbers, count)[rows]
        least, greatest = self._ranges[name]
        is_right = (chosen >= least) & (chosen <= greatest)
        if not is_right.all():
            raise UsageError(
                f'expected vary["{name}"] from {least:g} to {greatest:g}, found '
                f"{chosen[~is_right][0]:g}"
            )
        return chosen

    def put(self, core: _core.WorldBatch, values: FloatArray) -> FloatArray:
        """Gives all environments their values, (n, names).

        Returns:
            The former values.

        Raises:
            UsageError: a body cannot have its mass. Nothing has changed.
        """
        former = self._values
        changed = (values != self._values).any(axis=1)
        if self.settings and changed.any():
            try:
                core.set_settings(values.take(self._columns, axis=1), changed)
            except ValueError as error:
                core.set_settings(self._values.take(self._columns, axis=1), changed)
                raise UsageError(f"vary: {error}") from None
        self._values = values
        for column, robot, number in self._noise_places:
            self.noises[robot][:, number] = values[:, column]
        return former

    def of(self, environment: int) -> Optional[Dict[str, float]]:
        """The values in an environment; None if nothing varies."""
        values = dict(zip(self._names, self._values[environment].tolist()))
        return values if self else None

    def config_of(self, environment: int) -> WorldConfig:
        """The world of an environment."""
        return with_values(self._original, self.of(environment) or {})

    def take(self, core: _core.WorldBatch, indices: IntArray, states: Sequence[Any]) -> FloatArray:
        """Gives environments the values of their states, where they have some.

        Returns:
            The former values, for `put`.

        Raises:
            StateError: a state has other names, or values beyond the ranges.
        """
        values = self._values.copy()
        for k, state in zip(indices.tolist(), states):
            if state is None:
                continue
            if not isinstance(state, dict) or list(state) != self._names:
                found = listed(list(state)) if isinstance(state, dict) else shown(state)
                raise StateError(
                    f"expected a state with values of: {listed(self._names)}; found {found}"
                )
            for column, (name, value) in enumerate(state.items()):
                least, greatest = self._ranges[name]
                if not isinstance(value, float) or not least <= value <= greatest:
                    raise StateError(
                        f'expected a state with "{name}" from {least:g} to {greatest:g}, found '
                        f"{shown(value)}"
                    )
                values[k, column] = value
        return self.put(core, values)

    # Which of the core's numbers follow

    def _find(self, count: int) -> None:
        """Finds the numbers of the core, by worlds with other values."""
        greatest = {name: high for name, (_, high) in self._ranges.items()}
        world = self._loaded(greatest)
        self._count = len(world.physics.settings)
        noises = [_noise_of(each) for each in self._robots(world)]
        for column, (name, (least, high)) in enumerate(self._ranges.items()):
            lower = [
                (value, self._loaded({**greatest, name: value}))
                for value in (0.5 * (least + high), least)
            ]
            places = self._places(world, high, lower) if least < high else []
            for _, other in lower:
                other.close()
            if places is None:
                raise UsageError(
                    f'vary: "{name}" cannot differ between environments from {least:g} to '
                    f"{high:g}; numbers of drives, of lidars, of dampings and of the materials of "
                    "footprints can, if they do not change what there is"
                )
            for place in places:
                if place < self._count:
                    self.settings.append(place)
                    self._columns.append(column)
                else:
                    self._noise_places.append((column, *divmod(place - self._count, 3)))
        world.close()
        for _, robot, _ in self._noise_places:
            self.noises[robot] = np.tile(noises[robot], (count, 1))

    def _places(
        self, world: World, value: float, lower: Sequence[Tuple[float, World]]
    ) -> Optional[List[int]]:
        """The indices of the core's numbers that are a value; None if not only these follow it.

        Args:
            world: with the value.
            value: of a number in a file.
            lower: the same world with two other values: one between all, and the least.
        """
        middle, other = lower[0]
        base, found = self._numbers(world), self._numbers(other)
        if len(found) != len(base):
            return None
        places = np.flatnonzero(found != base)
        physical = places[places < self._count]
        follows = (
            len(places) > 0
            and _are_all(found[places], middle)
            and _are_all(base[places], value)
            and all(self._is_equal(world, each, physical, lowered) for lowered, each in lower)
        )
        return places.tolist() if follows else None

    def _loaded(self, values: Mapping[str, float]) -> World:
        try:
            return self._load(with_values(self._original, values))
        except UsageError:
            raise
        except FlatlandError as error:
            raise UsageError(str(error)) from error

    def _numbers(self, world: World) -> FloatArray:
        """The core's settings in a world, and those of the robots' noise."""
        noises = [_noise_of(each) for each in self._robots(world)]
        return np.concatenate([world.physics.settings, *noises])

    def _is_equal(self, world: World, other: World, settings: IntArray, value: float) -> bool:
        """True if a world becomes equal to another one by these settings, and moves alike."""
        if world.physics.grip_count != other.physics.grip_count:
            return False  # without contacts, a drive of unlimited force moves alike
        found = []
        for each, varied in ((world, settings.tolist()), (other, [])):
            robots = self._robots(each)
            core = make_core(each, robots, 1, varied=varied)
            rows = len(robots)
            ranges, motions = np.empty((rows, core.beams), np.float32), np.empty((3, rows, 3))
            out = (ranges, *motions, np.empty(rows, bool), np.empty(1, np.int64))
            if varied:
                core.set_settings(np.full((1, len(varied)), value), None)
            core.reset(None, None, out, None)
            for plugin in roles_of(each):  # without noise, a drive has drawn no key
                if plugin.role.drive is not None:
                    core.seed(plugin.role.drive.drive, np.zeros(1, np.uint64), None)
            state = core.save_state(0) if len(each.physics.settings) == self._count else b""
            core.step(np.full((rows, len(robots[0].action_names)), 0.3), 20, 0.01, out)
            found.append((state, ranges.tobytes(), motions.tobytes()))
        (state, *motion), (other_state, *other_motion) = found
        return motion == other_motion and (state == other_state or not other_state)


def _noise_of(robot: Robot) -> FloatArray:
    """The settings of the noise of a robot's lidar; zeros without noise of the core."""
    make_noise = robot.core_lidar.make_noise
    noise = make_noise and make_noise(plugin_rng(0, "", ""))
    return np.array(noise.settings if isinstance(noise, _core.RangeNoise) else [0.0] * 3)


def _are_all(numbers: FloatArray, value: float) -> bool:
    """True if all are a value, or its nearest number of single precision, which Box2D takes."""
    return bool(((numbers == value) | (numbers == np.float64(np.float32(value)))).all())

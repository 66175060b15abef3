"""Reads scenario files; docs/reference/sweeps.md describes them."""

from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, TypeVar

from flatland2d.sweep.controllers import POLICY_DRIVER, python_file
from flatland2d.sweep.parameters import combinations, count_combinations, world_file
from flatland2d.sweep.settings import RANDOM, Controller, SweepSettings, SweepWorld, Task
from flatland_server.arguments import steps_in
from flatland_server.config import SCENE_GOALS, YamlReader, is_file
from flatland_server.exceptions import FlatlandError, UsageError, YamlError, shortened
from flatland_server.timekeeper import Timekeeper

MAX_SCENARIOS = 10_000_000
_MOST_DIGITS = 30
"""Of a seed in a list."""

_TO_GOALS = (POLICY_DRIVER, "flatland2d.sweep.drivers:gaps", "flatland2d.sweep.orca:orca")
"""Controllers that are nothing without a goal."""

_Named = TypeVar("_Named", SweepWorld, Controller)


def read_scenario_file(path: Path) -> SweepSettings:
    """The content of a scenario file.

    Raises:
        YamlError: something in it is wrong; lists everything that was found.
    """
    path = path.absolute()
    reader = YamlReader.from_file(path)
    settings = SweepSettings(
        file=path,
        worlds=_worlds(reader, _task(reader, Task()), reader.get_string("group", "")),
        controllers=_controllers(reader),
        seeds=_seeds(reader),
        parameters=_parameters(reader),
        step_size=reader.get_float("step_size", 0.005, above=0.0),
        control_period=reader.get_float("control_period", 0.05, above=0.0),
        time_limit=reader.get_float("time_limit", 60.0, above=0.0),
        real_time_limit=reader.get_float("real_time_limit", 600.0, above=0.0),
        collision_ends=reader.get_bool("collision_ends", True),
        retries=reader.get_int("retries", 2, minimum=0, maximum=100),
    )
    if reader.is_sound:
        _check_durations(reader, settings)
    count = len(settings.worlds) * len(settings.controllers) * len(settings.parameters)
    if count * len(settings.seeds) > MAX_SCENARIOS:
        reader.problem(f"expected at most {MAX_SCENARIOS} scenarios, found more")
    for world, controller in product(settings.worlds, settings.controllers):
        if world.task.goal is None and controller.target in _TO_GOALS:
            reader.problem(
                f'expected a goal in world "{shortened(world.name)}", to which the controller '
                f'"{shortened(controller.name)}" drives, found none',
                "worlds",
            )
    reader.finish()
    return settings


def _check_durations(reader: YamlReader, settings: SweepSettings) -> None:
    """Notes an invalid step size, and durations that are no multiples of it."""
    try:
        Timekeeper(settings.step_size)
    except UsageError as error:
        reader.problem(str(error), "step_size")
        return
    for name in ("control_period", "time_limit"):
        try:
            steps_in(getattr(settings, name), settings.step_size, name)
        except UsageError as error:
            reader.problem(str(error), name)


def _task(reader: YamlReader, default: Task) -> Task:
    """The task of the robot, from the top of the file or an entry of `worlds`."""
    least, largest = reader.get_floats("goal_distance", 2, default.goal_distance, minimum=0.0)
    if least > largest:
        reader.problem("expected the least and the largest distance [m]", "goal_distance")
    return Task(
        robot=reader.get_string("robot", default.robot),
        start=_place(reader, "start", reader.get_pose, "[x, y, yaw]", default.start),
        goal=_place(reader, "goal", reader.get_point, "[x, y]", default.goal),
        goal_radius=reader.get_float("goal_radius", default.goal_radius, above=0.0),
        goal_distance=(least, largest),
        margin=reader.get_float("margin", default.margin, minimum=0.0),
        shortest_path=reader.get_float("shortest_path", default.shortest_path, above=0.0),
        top_speed=reader.get_float("top_speed", default.top_speed, above=0.0),
    )


def _place(
    reader: YamlReader, key: str, get: Callable[[str], Any], expected: str, default: Any
) -> Any:
    """A place, or the word "random"; or the default, if the key is not given."""
    if reader.is_list(key):
        return get(key)
    word = reader.get_string(key, default)
    if reader.has(key) and word not in ("", RANDOM):  # "": noted as no string
        reader.problem(f'expected {expected} or {RANDOM}, found "{shortened(str(word))}"', key)
    return word


def _worlds(reader: YamlReader, task: Task, group: str) -> Tuple[SweepWorld, ...]:
    """The entries of `worlds`: names, files, and maps, which may be mixed."""
    if _is_list_of_maps(reader, "worlds"):

        def read(entry: YamlReader) -> SweepWorld:
            source = entry.get_string("world")
            name = entry.get_string("name", _short_name(source))
            _check_world(entry, "world", source)
            of = entry.get_string("group", group)
            world = _world(name, source, _task(entry, task), of)
            entry.finish()
            return world

        return _named(
            reader, "worlds", reader.get_sections("worlds", read, required=True, word="world")
        )
    sources = reader.get_strings("worlds")
    for source in sources:
        _check_world(reader, "worlds", source)
    return _named(reader, "worlds", [_world(_short_name(s), s, task, group) for s in sources])


def _world(name: str, source: str, task: Task, group: str) -> SweepWorld:
    """A world; a shipped scene has its goal, unless the file gives another one."""
    if task.goal is None:
        task = replace(task, goal=SCENE_GOALS.get(source))
    return SweepWorld(name, source, task, group)


def _short_name(source: str) -> str:
    """A world's name, if none is given: that of the shipped world, or of the file."""
    path = Path(source)
    return path.parent.name if path.stem == "world" and path.parent.name else path.stem


def _check_world(reader: YamlReader, key: str, source: str) -> None:
    if not source:
        return  # noted by the getter, or empty
    try:
        world_file(source, reader.file.parent)
    except FlatlandError as error:
        reader.problem(str(error), key)


def _controllers(reader: YamlReader) -> Tuple[Controller, ...]:
    """The entries of `controllers`; without any, the worlds run by themselves."""

    def read(entry: YamlReader) -> Controller:
        name = entry.get_string("name")
        target = entry.get_string("call", "")
        arguments = entry.get_section("arguments")
        values = arguments.content()
        arguments.accept_other_keys()
        policy = entry.get_string("policy", "")
        if target and policy:
            entry.problem('expected "call" or "policy", found both')
        if entry.has("policy"):
            entry.get_path("policy")
            target = POLICY_DRIVER
        elif entry.has("call"):
            _check_target(entry, target)
        entry.finish()
        return Controller(name, target, values, policy)

    found = reader.get_sections("controllers", read)
    return _named(reader, "controllers", found) if reader.has("controllers") else (_NONE,)


_NONE = Controller("none")


def _check_target(entry: YamlReader, target: str) -> None:
    module, _, function = target.rpartition(":")
    if not module or not function.isidentifier():
        entry.problem(
            'expected a function as "module:function" or "file.py:function", '
            f'found "{shortened(target)}"',
            "call",
        )
        return
    file = python_file(target, entry.file.parent)
    if file is not None and not is_file(file):
        entry.problem(f"expected a file, but {file} is not there", "call")


def _named(reader: YamlReader, key: str, entries: Sequence[_Named]) -> Tuple[_Named, ...]:
    """Entries, checked for names that are given twice."""
    names = [entry.name for entry in entries]
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            reader.problem(f'the name "{shortened(name)}" is given twice', key)
    if not entries and reader.is_sound:
        reader.problem("expected one at least, found none", key)
    return tuple(entries)


def _seeds(reader: YamlReader) -> Tuple[int, ...]:
    """A number of seeds from 0, a list of them, or `{first: 100, count: 20}`."""
    if reader.is_map("seeds"):
        section = reader.get_section("seeds")
        first = section.get_int("first", 0, minimum=0)
        count = section.get_int("count", minimum=1, maximum=MAX_SCENARIOS)
        section.finish()
        return tuple(range(first, first + count))
    if not reader.is_list("seeds"):
        return tuple(range(reader.get_int("seeds", 1, minimum=1, maximum=MAX_SCENARIOS)))
    seeds: List[int] = []
    for word in reader.get_strings("seeds"):
        if not (word.isdecimal() and len(word) <= _MOST_DIGITS):
            reader.problem(
                f"expected seeds of 0 or more, of at most {_MOST_DIGITS} digits, found "
                f'"{shortened(word)}"',
                "seeds",
            )
        elif int(word) in seeds:
            reader.problem(f"the seed {word} is given twice", "seeds")
        else:
            seeds.append(int(word))
    if not seeds and reader.is_sound:
        reader.problem("expected one seed at least, found none", "seeds")
    return tuple(seeds)


def _parameters(reader: YamlReader) -> Tuple[Dict[str, Any], ...]:
    """The combinations of one grid, or of each of a list of them."""
    if _is_list_of_maps(reader, "parameters"):
        grids: List[Dict[str, Any]] = reader.get_sections("parameters", _grid)
    else:
        section: Optional[YamlReader] = reader.get_section("parameters")
        grids = [_grid(section)] if section is not None else []
    if count_combinations(grids) > MAX_SCENARIOS:
        reader.problem(
            f"expected at most {MAX_SCENARIOS} combinations of values, found "
            f"{count_combinations(grids)}",
            "parameters",
        )
        return ({},)
    found = combinations(grids)
    texts = [repr(sorted(each.items())) for each in found]
    if len(set(texts)) < len(texts):
        reader.problem("a combination of values is given twice", "parameters")
    return tuple(found)


def _grid(section: YamlReader) -> Dict[str, Any]:
    section.accept_other_keys()
    content = section.content()
    for name, value in content.items():
        if not name.startswith("/") and "." not in name:
            section.problem(
                'expected a name such as "/name" of an expression, "controller.name" or '
                f'"models.name.pose", found "{shortened(name)}"',
                name,
            )
        if isinstance(value, dict) or value == []:
            section.problem("expected a value or a list of values", name)
    section.finish()
    return content


def _is_list_of_maps(reader: YamlReader, key: str) -> bool:
    """True if a key has a list with a map in it."""
    if not reader.is_list(key):
        return False
    try:
        return any(isinstance(entry, dict) for entry in reader.content()[key])
    except (YamlError, ValueError):
        return True  # `get_sections` says what is wrong

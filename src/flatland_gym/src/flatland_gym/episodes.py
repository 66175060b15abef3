"""Initial states of episodes, drawn from the random numbers of their environment.

The start and the goal lie in free space that is connected, away from walls and from other models.
Scattered models stay so far from walls, from each other, from the start and from the goal that the
robot fits through; one that finds no place takes no part in the episode.
"""

import math
from dataclasses import dataclass, field, replace
from itertools import groupby
from operator import attrgetter
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from flatland2d import Point, Pose, UsageError
from flatland2d.batch.variation import ranges_of
from flatland2d.free_space import Circle, Circles
from flatland_gym.maps import Maps
from flatland_gym.navigation_world import NavigationWorld, parking_place
from flatland_gym.settings import NavigationSettings, is_whole
from flatland_server import Segments, from_segments
from flatland_server.exceptions import unknown

_TRIES = 500
_TRIES_OF_MODELS = 60

_DRAWN = ("world", "goal_distance", "margin", "obstacles", "robot_scales", "vary")
_ARRAYS = {"start": 2, "goal": 2, "vary": 1}
"""The options that may be arrays with a row for each environment, and the rank of these."""
OPTIONS = ("start", "goal", *_DRAWN, "map")
"""The keys of `reset(options=...)`."""


@dataclass(frozen=True)
class Episode:
    """The beginning of an episode.

    Attributes:
        world: index of the world.
        seed: of the simulation.
        starts: of the robots' origins, in the world.
        goals: x, y [m] in the world, for each robot.
        places: poses of other models, by name.
        map: its number; None without maps.
        vary: the numbers of model files that differ between episodes, by name.
    """

    world: int
    seed: int
    starts: Tuple[Pose, ...]
    goals: Tuple[Point, ...]
    places: Mapping[str, Pose]
    map: Optional[int] = None
    vary: Mapping[str, float] = field(default_factory=dict)

    def is_near(self, walls: Segments, distance: float) -> bool:
        """True if a start or a goal is nearer than this [m] to one of some walls."""
        if not len(walls):
            return False
        places = [*(start[:2] for start in self.starts), *self.goals]
        away = from_segments(np.array(places), walls)
        return bool(np.hypot(away[..., 0], away[..., 1]).min() < distance)


@dataclass(frozen=True)
class Choice:
    """The worlds, places and sizes that episodes are drawn from.

    Attributes:
        worlds: the indices of the worlds.
        settings: those of the environment, with the options in place of arguments.
        ends: start and goal of each robot, where options give them.
        maps: the numbers of the maps; empty without.
    """

    worlds: Tuple[int, ...]
    settings: NavigationSettings
    ends: Sequence["_Ends"]
    maps: Sequence[int]


class EpisodeSampler:
    """Draws episodes.

    Args:
        worlds: worlds that episodes choose from.
        settings: settings of the environment.
        maps: the maps of `settings`; None without any.
        count: number of environments, n.
    """

    def __init__(
        self,
        worlds: Sequence[NavigationWorld],
        settings: NavigationSettings,
        maps: Optional[Maps],
        count: int,
    ) -> None:
        self._count = count
        self._maps = maps
        self._worlds = worlds
        self._settings = settings
        self._usual: Dict[int, List[_Ends]] = {}  # that the worlds themselves give

    def choices(self, options: Mapping[str, Any]) -> List[Choice]:
        """The choice that options leave to each environment; a single one if it is that of all.

        Args:
            options: `start` ([x, y] or [x, y, yaw]) and `goal` ([x, y]), which are otherwise drawn,
                or with several robots dicts of these by the robot's name, for all or some of them;
                `map`, the number of a map, or several to draw one from; and `world`,
                `goal_distance`, `margin`, `obstacles`, `robot_scales` and `vary`, in place of the
                environment's arguments, within what these have made: some of the worlds and
                sizes, at most this margin and as many obstacles, and numbers within these ranges.
                A start or a goal for each environment has the shape (n, 2) or (n, 3), a number of
                `vary` is an array (n,).

        Raises:
            UsageError: an option is unknown or wrong.
        """
        parts = _by_environment(options, self._count)
        return [self._choice(each) for each in parts]

    def _choice(self, options: Mapping[str, Any]) -> Choice:
        settings = self._settings
        for name in options:
            if name not in OPTIONS:
                raise UsageError(f"unknown option {name!r}; there are: {', '.join(OPTIONS)}")
        given = {name: options[name] for name in _DRAWN if options.get(name) is not None}
        if given:
            if "vary" in given:
                given["vary"] = self._ranges(given["vary"])
            settings = replace(settings, **given)
            most = self._settings.obstacle_counts[1]
            if settings.obstacle_counts[1] > most:
                raise UsageError(
                    f"expected the option obstacles of at most {most}, the environment's largest "
                    f"number, found {settings.obstacles!r}"
                )
            if settings.margin > self._settings.margin:
                raise UsageError(
                    f"expected the option margin of at most {self._settings.margin:g} m, as in the "
                    f"environment's arguments, found {settings.margin:g}"
                )
        return Choice(
            tuple(self._indices(given)),
            settings,
            _given_ends(options, self._worlds[0].robots),
            self._map_numbers(options.get("map")),
        )

    def draw(self, rng: np.random.Generator, choice: Choice) -> Episode:
        """An episode.

        Args:
            rng: the environment's random numbers.
            choice: what to draw from; see `choice`.

        Raises:
            UsageError: a place is wrong, such as a goal in a wall; or there is no room. The random
                numbers may have advanced, but nothing else has changed.
        """
        count = len(choice.worlds)
        index = choice.worlds[int(rng.integers(count)) if count > 1 else 0]
        world, chosen_map = self._worlds[index], None
        if self._maps is not None:
            chosen_map = choice.maps[int(rng.integers(len(choice.maps)))]
            world = self._maps[chosen_map].world
        if index not in self._usual:
            self._usual[index] = _given_ends(world.ends, world.robots)
        usual = self._usual[index]
        given = [
            _Ends(option.start or own.start, option.goal or own.goal, option.of)
            for option, own in zip(choice.ends, usual)
        ]
        seed = int(rng.integers(2**31))
        margin = choice.settings.margin
        if world.space.free_space(world.radius + margin).area == 0.0:
            raise UsageError(
                f'the world "{world.name}" has no room for a robot of {world.radius:g} m radius '
                f"and a margin of {margin:g} m"
            )
        standing: List[Circle] = [(disc.x, disc.y, disc.radius) for disc in world.standing]
        near_starts, near_goals = list(standing), list(standing)
        starts: List[Pose] = []
        goals: List[Point] = []
        for number, ends in enumerate(given, 1):
            later = given[number:]
            later_starts = [
                (each.start[0], each.start[1], world.radius) for each in later if each.start
            ]
            later_goals = [
                (each.goal[0], each.goal[1], world.radius) for each in later if each.goal
            ]
            circles = [*near_starts, *later_starts], [*near_goals, *later_goals]
            start, goal = self._ends(world, choice, ends, *circles, rng)
            starts.append(start)
            goals.append(goal)
            near_starts.append((start.x, start.y, world.radius))
            near_goals.append((*goal, world.radius))
        places = self._places(world, choice.settings, near_starts + near_goals, rng)
        vary = {name: rng.uniform(*range) for name, range in choice.settings.vary.items()}
        return Episode(index, seed, tuple(starts), tuple(goals), places, chosen_map, vary)

    def _ranges(self, given: Any) -> Dict[str, Tuple[float, float]]:
        """The ranges of the option `vary`, and those of other numbers as they are."""
        own = self._settings.vary
        ranges = ranges_of(_mapping("vary", given), or_numbers=True)
        for name, (low, high) in ranges.items():
            if name not in own:
                problem = "expected the option vary with names of the argument, found"
                raise UsageError(unknown(problem, name, own))
            least, greatest = own[name]
            if low < least or high > greatest:
                raise UsageError(
                    f'expected the option vary["{name}"] within {least:g} to {greatest:g}, as in '
                    f"the environment's arguments, found {low:g} to {high:g}"
                )
        return {**own, **ranges}

    def _map_numbers(self, given: Any) -> Sequence[int]:
        """The numbers of the maps that the option `map` leaves."""
        if given is None:
            return range(self._settings.num_maps)
        if self._maps is None:
            raise UsageError("expected no option map in an environment without maps")
        numbers = given if isinstance(given, Sequence) else np.atleast_1d(given)
        ends = [numbers[0], numbers[-1]] if isinstance(numbers, range) and numbers else numbers
        if not len(ends) or not all(is_whole(each) and 0 <= each < 2**63 for each in ends):
            raise UsageError(
                f"expected the option map as a number of 0 or more, or several, found {given!r:.80}"
            )
        return numbers if isinstance(numbers, range) else [int(each) for each in numbers]

    def _indices(self, options: Mapping[str, Any]) -> List[int]:
        """The indices of the worlds that options leave."""
        names = [world.name for world in self._worlds]
        sizes = [float(world.scale) for world in self._worlds]
        found = list(range(len(self._worlds)))
        for option, values in (("world", names), ("robot_scales", sizes)):
            if option not in options:
                continue
            given = options[option]
            wanted = given if isinstance(given, (list, tuple, np.ndarray)) else [given]
            for each in wanted:
                if each not in values:
                    known = ", ".join(map(str, dict.fromkeys(values)))
                    raise UsageError(
                        f"expected the option {option} to be one of: {known}; found {each!r}"
                    )
            found = [index for index in found if values[index] in wanted]
        return found

    def _ends(
        self,
        world: NavigationWorld,
        choice: Choice,
        given: "_Ends",
        starts: Circles,
        goals: Circles,
        rng: np.random.Generator,
    ) -> Tuple[Pose, Point]:
        """A start and a goal that are clear of the other robots' starts and goals."""
        room = world.radius + choice.settings.margin
        space = world.space.free_space(room)
        given_start, given_goal = given.start, given.goal
        if given_start:
            _require_free(world, f"start{given.of}", given_start[:2], starts)
        if given_goal:
            _require_free(world, f"goal{given.of}", given_goal, goals)
        least, largest = choice.settings.goal_distance
        distances = least, max(least, min(largest, world.space.diagonal))
        ends = (
            (given_start[0], given_start[1]) if given_start else None,
            (given_goal[0], given_goal[1]) if given_goal else None,
        )
        found = space.ends(rng, ends, distances, room, (starts, goals), _TRIES)
        if found is None:
            raise UsageError(
                f'the world "{world.name}" has no free start and goal {least:g} to {largest:g} m '
                f"apart (tried {_TRIES} times)"
            )
        start, goal = found
        yaw = given_start[2] if len(given_start) > 2 else start.yaw
        return Pose(start.x, start.y, yaw), goal

    def _places(
        self,
        world: NavigationWorld,
        settings: NavigationSettings,
        taken: List[Circle],
        rng: np.random.Generator,
    ) -> Dict[str, Pose]:
        """Poses of the scattered models and of the obstacles."""
        low, high = settings.obstacle_counts
        count = len(world.scattered) + (int(rng.integers(low, high + 1)) if high else 0)
        discs = (*world.scattered, *world.obstacles)
        if not discs:
            return {}
        places = {disc.name: parking_place(number) for number, disc in enumerate(discs)}
        for radius, group in groupby(discs[:count], attrgetter("radius")):
            names = [disc.name for disc in group]
            passage = radius + 2 * (world.radius + settings.margin)
            space = world.space.free_space(passage)
            if space.area == 0.0:  # too narrow to leave a passage: models may be beside a wall
                space = world.space.free_space(radius + settings.margin)
            if space.area == 0.0:
                continue
            found = space.clear_poses(rng, taken, radius, passage, len(names), _TRIES_OF_MODELS)
            clear = {name: pose for name, pose in zip(names, found) if pose is not None}
            places.update(clear)
            taken.extend((pose.x, pose.y, radius) for pose in clear.values())
        return places


def options_of(options: Any) -> Dict[str, Any]:
    """The options of a reset: a new dict.

    Raises:
        UsageError: they are no mapping.
    """
    if not (options is None or isinstance(options, Mapping)):
        raise UsageError(f"expected options as a dict, found {options!r:.80}")
    return dict(options or {})


def _mapping(name: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise UsageError(f"expected the option {name} as a dict by name, found {value!r:.80}")
    return value


def _by_environment(options: Mapping[str, Any], count: int) -> List[Dict[str, Any]]:
    """The options of each environment if an array has a row for each; else those of all."""
    lengths = {}

    def look(name: str, value: Any, rank: int) -> None:
        if isinstance(value, Mapping):
            for key, each in value.items():
                look(f"{name} of {key}", each, rank)
        elif _is_array(value, rank):
            lengths[name] = len(value)

    def row(value: Any, rank: int, k: int) -> Any:
        if isinstance(value, Mapping):
            return {key: row(each, rank, k) for key, each in value.items()}
        return value[k] if _is_array(value, rank) else value

    for name, rank in _ARRAYS.items():
        look(name, options.get(name), rank)
    for name, length in lengths.items():
        if length != count:
            raise UsageError(
                f"expected the option {name} for {count} environments, found {length} rows"
            )
    if not lengths:
        return [dict(options)]
    return [
        {name: row(value, _ARRAYS.get(name, 0), k) for name, value in options.items()}
        for k in range(count)
    ]


def _is_array(value: Any, rank: int) -> bool:
    """True for an option with a row for each environment: an array of this rank."""
    return isinstance(value, np.ndarray) and rank > 0 and value.ndim == rank


def _require_free(
    world: NavigationWorld, name: str, place: Sequence[float], standing: Circles
) -> None:
    """Raises a UsageError if the robot cannot stand at a place, or cannot get there."""
    x, y = place
    expected = f"expected a {name} that is free and can be reached, found [{x:g}, {y:g}]"
    clearance = world.space.distance(x, y)
    if clearance <= world.radius:
        raise UsageError(
            f"{expected}, at most {clearance:g} m from a wall or outside of the world; the "
            f"robot has a radius of {world.radius:g} m"
        )
    if not world.space.free_space(world.radius).contains_point(x, y):
        raise UsageError(f"{expected}, which walls separate from the robot")
    for a, b, radius in standing:
        if math.hypot(x - a, y - b) <= world.radius + radius:
            raise UsageError(f"{expected}, where another model stands")


class _Ends(NamedTuple):
    """The ends that options give to a robot; empty if they are drawn."""

    start: List[float]
    goal: List[float]
    of: str
    """Continues "start" or "goal" in messages, where there are several robots."""


def _given_ends(options: Mapping[str, Any], robots: Sequence[str]) -> List[_Ends]:
    """The ends of each robot in options.

    Raises:
        UsageError: one is wrong.
    """
    start, goal = options.get("start"), options.get("goal")
    if len(robots) == 1:
        return [_Ends(_numbers("start", start), _numbers("goal", goal), "")]
    starts, goals = _by_robot("start", start, robots), _by_robot("goal", goal, robots)
    return [
        _Ends(
            _numbers(f"start of {robot}", starts.get(robot)),
            _numbers(f"goal of {robot}", goals.get(robot)),
            f" of {robot}",
        )
        for robot in robots
    ]


def _by_robot(name: str, value: Any, robots: Sequence[str]) -> Mapping[str, Any]:
    """An option with an entry for some of several robots."""
    if value is None:
        return {}
    if not isinstance(value, Mapping) or not set(value) <= set(robots):
        found = f"{value!r:.80}"
        raise UsageError(
            f"expected the option {name} as a dict by agent, of: {', '.join(robots)}; found {found}"
        )
    return value


def _numbers(name: str, value: Any) -> List[float]:
    """An end as a list of finite floats; an empty one for None."""
    if value is None:
        return []
    try:
        numbers = [float(number) for number in value]
    except (TypeError, ValueError, OverflowError):
        numbers = []
    sizes, form = ((2, 3), "[x, y] or [x, y, yaw]") if "start" in name else ((2,), "[x, y]")
    if len(numbers) not in sizes or not all(map(math.isfinite, numbers)):
        raise UsageError(f"expected the option {name} as {form}, found {value!r}")
    return numbers

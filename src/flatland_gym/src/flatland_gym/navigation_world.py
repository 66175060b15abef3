"""A world of an environment: loaded once, with the facts that its episodes need."""

import itertools
import math
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import AbstractSet, Any, Dict, List, Mapping, Sequence, Set, Tuple, Union

import numpy as np

from flatland2d import DistanceGrid, FlatlandError, Pose, Simulation, UsageError, find_robot
from flatland2d.batch.variation import with_values
from flatland2d.world_source import content_with
from flatland_gym.map_space import MapSpace
from flatland_gym.robot import Content, Robot, scale_footprints, set_beams
from flatland_gym.scenarios import SCENARIOS
from flatland_gym.settings import NavigationSettings, WorldName
from flatland_server import Segments, WorldConfig
from flatland_server.arguments import params_of
from flatland_server.exceptions import unknown
from flatland_server.transport import LocalTransport, absolute_name

PARKING = 5000.0
"""x and y [m] for models out of play: far from all walls, beyond the range of any lidar."""

_PARKING_SPACE = 10.0  # m
_OBSTACLE = "obstacle_"
_OPEN = 10.0
"""Reach of the space around the robot in a world without walls [m]."""


@dataclass(frozen=True)
class Disc:
    """A model as an episode sees it: a disc about the model's origin.

    Attributes:
        name: the model's name.
        x: at the beginning of the world [m].
        y: at the beginning of the world [m].
        radius: [m].
    """

    name: str
    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class NavigationWorld:
    """A world of an environment.

    Attributes:
        name: as the settings name it; "world" for a dict.
        config: of its simulations.
        robot: the robot to drive.
        robots: the names of the models: that of the robot, or of so many robots like it.
        scale: of the robot, relative to the world's.
        radius: the robot's radius [m].
        walls: of all its layers.
        space: where it can stand.
        standing: the models that stay where the world file puts them.
        scattered: the models that each episode places at random.
        obstacles: the added columns, of which each episode uses some.
        ends: the `start` and the `goal` of its episodes, unless options give others.
        params_read: the parameters that its files and plugins have read.
    """

    name: str
    config: WorldConfig
    robot: Robot
    robots: Tuple[str, ...]
    scale: float
    radius: float
    walls: Segments
    space: Union[DistanceGrid, MapSpace]
    standing: Tuple[Disc, ...]
    scattered: Tuple[Disc, ...]
    obstacles: Tuple[Disc, ...]
    ends: Mapping[str, Sequence[float]]
    params_read: AbstractSet[str]

    @property
    def others(self) -> Tuple[str, ...]:
        """The names of all models but the robots."""
        return tuple(disc.name for disc in (*self.standing, *self.scattered, *self.obstacles))

    def radii(self, names: Sequence[str]) -> List[float]:
        """The radii of other models and of the robot together [m]; NaN for models not in it."""
        discs = (*self.standing, *self.scattered, *self.obstacles)
        own = {disc.name: disc.radius + self.radius for disc in discs}
        return [own.get(name, math.nan) for name in names]

    @classmethod
    def load(
        cls, world: WorldName, settings: NavigationSettings, scale: float = 1.0, robots: int = 1
    ) -> "NavigationWorld":
        """Loads a world.

        Args:
            world: an entry of `settings.worlds`.
            settings: the environment's settings.
            scale: of the robot, from `settings.robot_scales`.
            robots: with more than one, its robot is replaced by so many like it, which each have a
                namespace of their own.

        Raises:
            FlatlandError: there is no such world, something in its files is wrong, or it has no
                robot with a drive and a lidar.
        """
        scenario = SCENARIOS.get(world) if isinstance(world, str) else None
        transport = LocalTransport(params_of(settings.params), ())
        content = content_with(transport, scenario.world if scenario else world)
        inside, lidar = _prepared(content, settings, scale)
        added = _add_obstacles(content, settings)
        names = _multiplied(content, inside, robots)
        greatest = {name: high for name, (_, high) in settings.vary.items()}
        config = with_values(WorldConfig.from_content(content), greatest)
        parked = added.union(names if robots > 1 else ())  # they are out of the way: no warning
        entries = (replace(e, reader=None) if e.name in parked else e for e in config.models)
        config = replace(config, models=tuple(entries))
        with Simulation(config, params=settings.params) as simulation:
            patterns = settings.scatter
            if patterns is None:
                patterns = scenario.scatter if scenario else ()
            models = {name: handle.model for name, handle in simulation.models.items()}
            discs = {n: Disc(n, m.pose.x, m.pose.y, m.radius) for n, m in models.items()}
            _require_matches(patterns, discs)
            robot = Robot.of(simulation.world, names[0], lidar, settings)
            driven = [discs.pop(name) for name in names].pop()
            walls = np.concatenate(
                [np.empty((0, 4)), *(config.walls_of(layer) for layer in config.layers)]
            )
            params_read = transport.params_read | simulation.transport.params_read
            largest = max([driven.radius, *(disc.radius for disc in discs.values())])
            space = DistanceGrid.shared(
                walls,
                tuple(inside.get("pose") or (0.0, 0.0))[:2],
                largest + 2 * (driven.radius + settings.margin),
                open_reach=_OPEN,
            )
        moved = {n for n in discs if any(fnmatchcase(n, pattern) for pattern in patterns)} - added
        return cls(
            world if isinstance(world, str) else getattr(world, "name", "world"),
            config,
            robot,
            names,
            scale,
            driven.radius,
            walls,
            space,
            tuple(disc for disc in discs.values() if disc.name not in moved | added),
            tuple(disc for disc in discs.values() if disc.name in moved),
            tuple(disc for disc in discs.values() if disc.name in added),
            scenario.ends if scenario is not None and robots == 1 else {},
            params_read,
        )


def parking_place(index: int) -> Pose:
    """The pose of the model of this index while it is out of play."""
    return Pose(PARKING + _PARKING_SPACE * index, PARKING, 0.0)


def _prepared(content: Content, settings: NavigationSettings, scale: float) -> Tuple[Content, str]:
    """Changes a world as the settings say; returns the robot's entry and its lidar's name."""
    with Simulation(WorldConfig.from_content(content), params=settings.params) as simulation:
        robot = find_robot(simulation.world, settings.robot, settings.lidar)
        entry = _named(content["models"], robot.model.name)
        lidar = _named(entry["model"]["plugins"], robot.lidar.name)
    if settings.beams is not None:
        set_beams(lidar, settings.beams)
    if settings.lidar_noise is not None:
        lidar["noise_std_dev"] = settings.lidar_noise
    if scale != 1.0:
        scale_footprints(entry, scale)
    return entry, lidar["name"]


def _named(entries: Sequence[Content], name: str) -> Content:
    """The entry of this name."""
    return next(entry for entry in entries if entry["name"] == name)


def _add_obstacles(content: Content, settings: NavigationSettings) -> Set[str]:
    """Adds columns to a world, parked outside of it; returns their names."""
    taken = {entry["name"] for entry in content["models"]}
    names = (f"{_OBSTACLE}{number}" for number in itertools.count(1))
    free = (name for name in names if name not in taken)
    added = set()
    count = settings.obstacle_counts[1]
    for index, radius in enumerate(np.linspace(*settings.obstacle_radius, count)):
        footprint = {"type": "circle", "radius": float(radius), "density": 1.0}
        body = {"name": "column", "type": "static", "footprints": [footprint]}
        name = next(free)
        added.add(name)
        pose = list(parking_place(index))
        content["models"].append({"name": name, "pose": pose, "model": {"bodies": [body]}})
    return added


def _multiplied(content: Content, robot: Content, count: int) -> Tuple[str, ...]:
    """Replaces a robot by several ones, parked outside of the world; returns their names."""
    name = robot["name"]
    if count == 1:
        return (name,)
    names = tuple(f"{name}_{number}" for number in range(count))
    content["models"].remove(robot)
    for number, each in enumerate(names):
        pose = list(parking_place(-1 - number))
        content["models"].append({**robot, "name": each, "namespace": each, "pose": pose})
    return names


def load_all(settings: NavigationSettings, robots: int) -> List[NavigationWorld]:
    """The worlds of an environment: each with each scale of the robot.

    Args:
        settings: the environment's settings.
        robots: as for `NavigationWorld.load`.

    Raises:
        FlatlandError: one cannot be loaded, which the message names if there are several; their
            robots are not alike, or a parameter is read by none.
    """
    loaded: List[NavigationWorld] = []
    for index, world in enumerate(settings.worlds):
        try:
            for scale in settings.robot_scales:
                loaded.append(NavigationWorld.load(world, settings, scale, robots))
                _require_alike(loaded[0], loaded[-1])
        except FlatlandError as error:
            if len(settings.worlds) == 1:
                raise
            raise UsageError(f"world[{index}]: {error}") from error
    read = {name for world in loaded for name in world.params_read}
    for name in settings.params:
        if absolute_name(name) not in read:
            known = sorted(each for each in read if not each.startswith("/~"))
            raise UsageError(unknown("nothing in the world reads the parameter", name, known))
    return loaded


def _require_alike(first: NavigationWorld, other: NavigationWorld) -> None:
    """Raises a UsageError unless the robots of two worlds have the same spaces."""
    for name in ("beams", "max_range", "action_limits", "velocity_limits"):
        a, b = getattr(first.robot, name), getattr(other.robot, name)
        if a != b:
            raise UsageError(
                f"expected worlds in which the robots are alike: {name} is {a} in {first.name}, "
                f"{b} in {other.name}"
            )


def _require_matches(patterns: Sequence[Any], names: Dict[str, Disc]) -> None:
    """Raises a UsageError for a pattern that no model matches."""
    unused: List[Any] = [p for p in patterns if not any(fnmatchcase(n, p) for n in names)]
    if unused:
        known = ", ".join(names)
        raise UsageError(
            f"expected scatter to match models, found {unused[0]!r}; there are: {known}"
        )

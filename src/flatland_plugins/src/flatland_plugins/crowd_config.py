"""The keys of a Crowd, and those that a Pedestrian shares with it."""

import itertools
import math
from dataclasses import astuple, dataclass, replace
from typing import Any, Collection, Dict, Iterator, List, Optional, Tuple

from flatland_plugins.recorded_people import RecordedPeople, Walk
from flatland_server import (
    CollisionFilterRegistry,
    Color,
    Point,
    Pose,
    UpdateTimer,
    YamlReader,
    check_topic_name,
)

WALK_RATIO = 0.0064 * 60.0
"""A step's length by the steps per second [m s], about equal at all speeds.

N. Sekiya et al., "The invariant relationship between step length and step rate during free
walking", Journal of Human Movement Studies 30, 1996.
"""


@dataclass(frozen=True)
class SocialForce:
    """The constants of the social force model; by default those of the papers, for 80 kg.

    D. Helbing, I. Farkas and T. Vicsek, "Simulating dynamical features of escape panic", Nature
    407, 2000; evasions: M. Moussaid et al., "Experimental study of the behavioural mechanisms
    underlying self-organization in human crowds", Proc. R. Soc. B 276, 2009.

    Attributes:
        relaxation_time: tau [s], in which a deviation from the desired velocity falls to 1/e.
        repulsion: A over the mass [m/s^2], the acceleration away from an obstacle on contact.
        range: B [m], over which the repulsion falls to 1/e.
        evasion: A of the evasions [m/s^2].
        side_preference: epsilon [rad/m], evades to the right; to the left if it is negative.
        noise: standard deviation of a walking person's velocity about the desired one [m/s], along
            each axis.
    """

    relaxation_time: float = 0.5
    repulsion: float = 2000.0 / 80.0
    range: float = 0.08
    evasion: float = 4.5
    side_preference: float = 0.005
    noise: float = 0.05


@dataclass(frozen=True)
class Orca:
    """The constants of optimal reciprocal collision avoidance.

    J. van den Berg, S. J. Guy, M. Lin and D. Manocha, "Reciprocal n-body collision avoidance",
    Robotics Research, 2011.

    Attributes:
        horizon: time without collisions with people and robots [s].
        wall_horizon: with walls [s].
        distance: up to which people count [m].
        neighbors: of the people within this distance, so many of the nearest count.
    """

    horizon: float = 2.0
    wall_horizon: float = 1.0
    distance: float = 5.0
    neighbors: int = 10


@dataclass(frozen=True)
class Attention:
    """Giving way to robots: the crowd's, unless a pedestrian's own entry says otherwise.

    Attributes:
        sees_robots: False: it never gives way to them, and walks into those that stand.
        yields: probability that it gives way in an encounter.
        reaction_time: from seeing a robot to giving way [s].
        field_of_view: in which it sees people and robots, about its heading [rad].
    """

    sees_robots: bool = True
    yields: float = 1.0
    reaction_time: float = 0.0
    field_of_view: float = 2.0 * math.pi

    @classmethod
    def read(cls, reader: YamlReader, default: "Attention") -> "Attention":
        """Reads the keys."""
        attention = cls(
            reader.get_bool("sees_robots", default.sees_robots),
            reader.get_float("yields", default.yields, minimum=0.0),
            reader.get_float("reaction_time", default.reaction_time, minimum=0.0),
            reader.get_float("field_of_view", default.field_of_view, minimum=0.0),
        )
        if attention.yields > 1.0 and reader.has("yields"):
            reader.problem(f"expected a number up to 1, found {attention.yields:g}", "yields")
        return attention


@dataclass(frozen=True)
class Build:
    """Speed and appearance of a pedestrian: the crowd's, unless its own entry says otherwise.

    Attributes:
        leg_offset: distance of a leg from the middle [m]; None: by the radius.
        walk_ratio: a step's length by the steps per second [m s]; 0 for legs that do not swing.
    """

    speed: float = 1.34
    radius: float = 0.25
    legs: bool = False
    color: Color = (0.9, 0.6, 0.3, 1.0)
    leg_offset: Optional[float] = None
    walk_ratio: float = WALK_RATIO

    @classmethod
    def read(cls, reader: YamlReader, default: "Build") -> "Build":
        """Reads the desired speed [m/s], the radius [m], and how they look."""
        return cls(
            speed=reader.get_float("speed", default.speed, above=0.0),
            radius=reader.get_float("radius", default.radius, minimum=0.01),
            legs=reader.get_bool("legs", default.legs),
            color=reader.get_color("color", default.color),
        )


@dataclass(frozen=True)
class PedestrianConfig:
    """An entry of `pedestrians`, or one of those that are put into the world at random.

    Without goals, it stays at its pose.

    Attributes:
        group: people of the same one keep together; None: of none.
        area: two corners [m]; its place and its goals are drawn there.
        stands: it stays at its drawn place.
        walks: recorded ones, which it follows instead.
    """

    name: str
    pose: Pose
    goals: Tuple[Point, ...]
    build: Build
    reader: YamlReader
    attention: Attention = Attention()
    group: Optional[str] = None
    area: Optional[Tuple[Point, Point]] = None
    stands: bool = False
    walks: Tuple[Walk, ...] = ()

    @classmethod
    def read(
        cls, reader: YamlReader, name: str, build: Build, attention: Attention
    ) -> "PedestrianConfig":
        """Reads an entry; `name`, `build` and `attention` are the defaults.

        Raises:
            YamlError: something in it is wrong.
        """
        name = reader.get_string("name", name)
        check_topic_name(reader, "name", name)
        pose = reader.get_pose("pose")
        goals = reader.get_points("goals", 1, 10_000, [pose[:2]])
        pedestrian = cls(
            name,
            pose,
            tuple(goals),
            Build.read(reader, build),
            reader,
            Attention.read(reader, attention),
            reader.get_string("group", None),
        )
        reader.finish()
        return pedestrian


@dataclass(frozen=True)
class WalkConfig:
    """The motion of people, and what they avoid.

    Attributes:
        layers: their collision layers; they avoid the walls of these.
        layer_bits: the bits of these layers.
        update_rate: the forces' update rate [Hz].
        goal_radius: distance at which a goal counts as reached [m].
        force: the social force model.
        orca: moves them instead of the forces.
    """

    layers: Tuple[str, ...]
    layer_bits: int
    update_rate: float
    goal_radius: float
    force: SocialForce
    orca: Optional[Orca]

    @property
    def settings(self) -> Dict[str, Any]:
        """Keyword arguments of the core's `add_crowd`."""
        return {
            "layers": self.layer_bits,
            "period": UpdateTimer(self.update_rate).period,
            "goal_radius": self.goal_radius,
            "forces": astuple(self.force),
            "orca": None if self.orca is None else astuple(self.orca),
        }

    @classmethod
    def read(cls, config: YamlReader, registry: CollisionFilterRegistry) -> "WalkConfig":
        """Reads the keys."""
        layers = config.get_strings("layers", ("all",))
        layer_bits = 0
        try:
            layer_bits = registry.bits(layers)
        except ValueError as error:
            config.problem(str(error), "layers")
        is_orca = config.get_choice("motion", ["social_force", "orca"], "social_force") == "orca"
        orca = _read_orca(config.get_section("orca"))
        return cls(
            layers=layers,
            layer_bits=layer_bits,
            update_rate=config.get_rate("update_rate", 20.0),
            goal_radius=config.get_float("goal_radius", 0.3, above=0.0),
            force=_read_force(config.get_section("force")),
            orca=orca if is_orca else None,
        )


@dataclass(frozen=True)
class CrowdConfig:
    """All keys of a crowd but its frame.

    Attributes:
        start: the range of times of its recording at which a world begins [s].
    """

    walk: WalkConfig
    poses_pub: str
    pedestrians: Tuple[PedestrianConfig, ...]
    start: Tuple[float, float] = (0.0, 0.0)

    @classmethod
    def read(
        cls,
        config: YamlReader,
        name: str,
        registry: CollisionFilterRegistry,
        taken: Collection[str],
    ) -> "CrowdConfig":
        """Reads the keys.

        Args:
            config: the plugin's configuration.
            name: of the crowd; its pedestrians have this name and a number.
            registry: the layers of the world.
            taken: the names of the models of the world.

        Raises:
            YamlError: something is wrong.
        """
        check_topic_name(config, "name", name)
        walk = WalkConfig.read(config, registry)
        build = Build.read(config, Build())
        attention = Attention.read(config, Attention())
        names: Dict[str, int] = {}

        def read_pedestrian(section: YamlReader) -> PedestrianConfig:
            pedestrian = PedestrianConfig.read(section, f"{name}_{len(names)}", build, attention)
            names[pedestrian.name] = names.get(pedestrian.name, 0) + 1
            if names[pedestrian.name] > 1:
                raise section.error(f'the name "{pedestrian.name}" is given twice', "name")
            if pedestrian.name in taken:
                raise section.error(f'a model named "{pedestrian.name}" is already there', "name")
            return pedestrian

        is_drawn = any(config.has(key) for key in ("random", "circle", "recording"))
        pedestrians = config.get_sections("pedestrians", read_pedestrian, required=not is_drawn)
        drawn: List[PedestrianConfig] = []
        for key, read in (("random", _read_random), ("circle", _read_circle)):
            if config.has(key):
                section = config.get_section(key)
                first = len(names) + len(drawn)
                drawn += read(section, _names(name, first), build, attention)
        start = (0.0, 0.0)
        if config.has("recording"):
            recorded = RecordedPeople.read(config.get_section("recording"))
            start = recorded.start
            free = _names(name, len(names) + len(drawn))
            drawn += [_follower(walks, next(free), build, recorded) for walks in recorded.bodies]
        for each in drawn:
            if each.name in names or each.name in taken:
                each.reader.problem(f'a model named "{each.name}" is already there')
        crowd = cls(
            walk=walk,
            poses_pub=config.get_topic("poses_pub", f"{name}/poses"),
            pedestrians=(*pedestrians, *drawn),
            start=start,
        )
        config.finish()
        return crowd


_MOST_DRAWN = 10_000


def _names(name: str, first: int) -> Iterator[str]:
    return (f"{name}_{number}" for number in itertools.count(first))


def _read_random(
    section: YamlReader, names: Iterator[str], build: Build, attention: Attention
) -> List[PedestrianConfig]:
    """The pedestrians with places and goals that are drawn."""
    count = section.get_int("count", minimum=0, maximum=_MOST_DRAWN)
    standing = section.get_int("standing", 0, minimum=0, maximum=_MOST_DRAWN)
    if standing > count:
        section.problem(f"expected at most the count, {count}, found {standing}", "standing")
    corners = section.get_points("area", 2, 2)
    section.finish()
    xs, ys = ([corner[axis] for corner in corners] for axis in range(2))
    low, high = (min(xs), min(ys)), (max(xs), max(ys))
    middle = ((low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0)
    person = PedestrianConfig(
        "", Pose(*middle), (middle,), build, section, attention, area=(low, high)
    )
    return [
        replace(person, name=name, stands=number < standing)
        for number, name in zip(range(count), names)
    ]


def _read_circle(
    section: YamlReader, names: Iterator[str], build: Build, attention: Attention
) -> List[PedestrianConfig]:
    """The pedestrians on a circle, who cross it; a robot is to begin at its place at angle 0."""
    count = section.get_int("count", minimum=0, maximum=_MOST_DRAWN)
    radius = section.get_float("radius", above=0.0)
    section.finish()
    people = []
    for number, name in zip(range(1, count + 1), names):
        angle = math.tau * number / (count + 1)
        x, y = radius * math.cos(angle), radius * math.sin(angle)
        pose = Pose(x, y, math.atan2(-y, -x))
        people.append(PedestrianConfig(name, pose, ((-x, -y),), build, section, attention))
    return people


def _follower(
    walks: Tuple[Walk, ...], name: str, build: Build, recorded: RecordedPeople
) -> PedestrianConfig:
    """The pedestrian that follows recorded walks."""
    _, x, y = walks[0][0].tolist()
    return PedestrianConfig(name, Pose(x, y), ((x, y),), build, recorded.reader, walks=walks)


def _read_orca(section: YamlReader) -> Orca:
    default = Orca()
    orca = Orca(
        horizon=section.get_float("horizon", default.horizon, above=0.0),
        wall_horizon=section.get_float("wall_horizon", default.wall_horizon, above=0.0),
        distance=section.get_float("distance", default.distance, above=0.0),
        neighbors=section.get_int("neighbors", default.neighbors, minimum=1, maximum=1000),
    )
    section.finish()
    return orca


def _read_force(section: YamlReader) -> SocialForce:
    default = SocialForce()
    preference = default.side_preference
    is_right = section.get_choice("side", ["right", "left"], "right") == "right"
    force = SocialForce(
        relaxation_time=section.get_float("relaxation_time", default.relaxation_time, above=0.0),
        repulsion=section.get_float("repulsion", default.repulsion, minimum=0.0),
        range=section.get_float("range", default.range, minimum=0.001),
        evasion=section.get_float("evasion", default.evasion, minimum=0.0),
        side_preference=preference if is_right else -preference,
        noise=section.get_float("noise", default.noise, minimum=0.0),
    )
    section.finish()
    return force

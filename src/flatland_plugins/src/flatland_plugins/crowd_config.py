"""The keys of a Crowd, and those that a Pedestrian shares with it."""

from dataclasses import astuple, dataclass
from typing import Any, Collection, Dict, Optional, Tuple

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
    """An entry of `pedestrians`. Without goals, it stays at its pose."""

    name: str
    pose: Pose
    goals: Tuple[Point, ...]
    build: Build
    reader: YamlReader

    @classmethod
    def read(cls, reader: YamlReader, name: str, build: Build) -> "PedestrianConfig":
        """Reads an entry; `name` and `build` are the defaults.

        Raises:
            YamlError: something in it is wrong.
        """
        name = reader.get_string("name", name)
        check_topic_name(reader, "name", name)
        pose = reader.get_pose("pose")
        goals = reader.get_points("goals", 1, 10_000, [pose[:2]])
        pedestrian = cls(name, pose, tuple(goals), Build.read(reader, build), reader)
        reader.finish()
        return pedestrian


@dataclass(frozen=True)
class WalkConfig:
    """The motion of people, and what they avoid.

    Attributes:
        layers: their collision layers; they avoid the walls of these.
        layer_bits: the bits of these layers.
        update_rate: of the forces [Hz].
        goal_radius: distance at which a goal counts as reached [m].
        force: the social force model.
    """

    layers: Tuple[str, ...]
    layer_bits: int
    update_rate: float
    goal_radius: float
    force: SocialForce

    @property
    def settings(self) -> Dict[str, Any]:
        """Keyword arguments of the core's `add_crowd`."""
        return {
            "layers": self.layer_bits,
            "period": UpdateTimer(self.update_rate).period,
            "goal_radius": self.goal_radius,
            "forces": astuple(self.force),
        }

    @classmethod
    def read(cls, config: YamlReader, registry: CollisionFilterRegistry) -> "WalkConfig":
        """Reads the keys.

        Args:
            config: the plugin's configuration.
            registry: the layers of the world.
        """
        layers = config.get_strings("layers", ("all",))
        layer_bits = 0
        try:
            layer_bits = registry.bits(layers)
        except ValueError as error:
            config.problem(str(error), "layers")
        return cls(
            layers=layers,
            layer_bits=layer_bits,
            update_rate=config.get_rate("update_rate", 20.0),
            goal_radius=config.get_float("goal_radius", 0.3, above=0.0),
            force=_read_force(config.get_section("force")),
        )


@dataclass(frozen=True)
class CrowdConfig:
    """All keys of a crowd but its frame."""

    walk: WalkConfig
    poses_pub: str
    pedestrians: Tuple[PedestrianConfig, ...]

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
        names: Dict[str, int] = {}

        def read_pedestrian(section: YamlReader) -> PedestrianConfig:
            pedestrian = PedestrianConfig.read(section, f"{name}_{len(names)}", build)
            names[pedestrian.name] = names.get(pedestrian.name, 0) + 1
            if names[pedestrian.name] > 1:
                raise section.error(f'the name "{pedestrian.name}" is given twice', "name")
            if pedestrian.name in taken:
                raise section.error(f'a model named "{pedestrian.name}" is already there', "name")
            return pedestrian

        crowd = cls(
            walk=walk,
            poses_pub=config.get_topic("poses_pub", f"{name}/poses"),
            pedestrians=tuple(config.get_sections("pedestrians", read_pedestrian, required=True)),
        )
        config.finish()
        return crowd


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

"""Joints: connections between two bodies of a model."""

from dataclasses import dataclass
from typing import Collection, Mapping, Optional, Tuple

from flatland_server.config.yaml_reader import Color, YamlReader
from flatland_server.exceptions import shortened
from flatland_server.geometry import Point
from flatland_server.models.model_body import ModelBody


@dataclass(frozen=True)
class JointConfig:
    """An entry of a model's `joints`: holds an anchor on one body at an anchor on another.

    Attributes:
        type: revolute or weld.
        name: unique within the model.
        color: of its marker in rviz.
        collide_connected: whether the two bodies collide with each other.
        bodies: the names of the two bodies.
        anchors: a point of each body, in its frame [m].
        limits: of a revolute joint: lowest and highest angle of the second body relative to the
            first [rad].
        angle: of a weld: angle of the second body relative to the first [rad].
        frequency: of a weld [Hz]; 0 is rigid.
        damping: of a weld: damping ratio.
    """

    type: str
    name: str
    color: Color
    collide_connected: bool
    bodies: Tuple[str, str]
    anchors: Tuple[Point, Point]
    limits: Optional[Tuple[float, float]] = None
    angle: float = 0.0
    frequency: float = 0.0
    damping: float = 0.0

    @classmethod
    def read(cls, reader: YamlReader, body_names: Collection[str]) -> "JointConfig":
        """Reads an entry; its `enabled` has been read.

        Raises:
            YamlError: something in it is wrong, or a body is not one of `body_names`.
        """
        kind = reader.get_choice("type", ["revolute", "weld"])
        limits = None
        if kind == "revolute" and reader.has("limits"):
            lower, upper = reader.get_floats("limits", 2)
            if lower > upper:
                message = f"expected [lower, upper], found {lower:g} above {upper:g}"
                reader.problem(message, "limits")
            limits = (lower, upper)
            reader.warn_of_degrees(max(limits, key=abs), "limits")
        ends = reader.get_sections(
            "bodies", lambda section: _read_end(section, body_names), required=True
        )
        reader.raise_problems()
        if len(ends) != 2:
            raise reader.error(f"expected two bodies, found {len(ends)}", "bodies")
        names, anchors = zip(*ends)
        if names[0] == names[1]:
            reader.problem(f'expected two bodies, found "{names[0]}" twice', "bodies")
        weld = kind == "weld"
        joint = cls(
            type=kind,
            name=reader.get_string("name"),
            color=reader.get_color("color", (1.0, 1.0, 1.0, 0.5)),
            collide_connected=reader.get_bool("collide_connected", False),
            bodies=(names[0], names[1]),
            anchors=(anchors[0], anchors[1]),
            limits=limits,
            angle=reader.get_float("angle", 0.0) if weld else 0.0,
            frequency=reader.get_float("frequency", 0.0, minimum=0.0) if weld else 0.0,
            damping=reader.get_float("damping", 0.0, minimum=0.0) if weld else 0.0,
        )
        reader.warn_of_degrees(joint.angle, "angle")
        reader.finish()
        return joint


def _read_end(reader: YamlReader, body_names: Collection[str]) -> Tuple[str, Point]:
    """Reads an entry of a joint's `bodies`: the name of a body, and the anchor on it [m]."""
    name = reader.get_name("name")
    if name and name not in body_names:
        hint = reader.suggestion(name, body_names)
        reader.problem(f'the model has no body "{shortened(name)}"{hint}', "name")
    anchor = reader.get_point("anchor")
    reader.finish()
    return name, anchor


class Joint:
    """A joint of a model in the world.

    Args:
        config: the joint's entry in the model file.
        bodies: the bodies of the model, by name.

    Attributes:
        config: as in the file; a plugin may have set other limits since.
        physics_joint: Box2D's joint, with its present angle, limits and motor.
    """

    def __init__(self, config: JointConfig, bodies: Mapping[str, ModelBody]) -> None:
        self.config = config
        first, second = (bodies[name].physics_body for name in config.bodies)
        if config.type == "revolute":
            self.physics_joint = first.add_revolute(
                second,
                *config.anchors,
                collide_connected=config.collide_connected,
                limits=config.limits,
            )
        else:
            self.physics_joint = first.add_weld(
                second,
                *config.anchors,
                collide_connected=config.collide_connected,
                angle=config.angle,
                frequency=config.frequency,
                damping=config.damping,
            )

    @property
    def name(self) -> str:
        """Its name, unique within the model."""
        return self.config.name

"""Bodies: the rigid parts of a model."""

from dataclasses import dataclass, field
from typing import Optional, Tuple

from flatland_server import _core
from flatland_server.config.yaml_reader import Color, YamlReader
from flatland_server.geometry import Pose, wrap_angle
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.footprint import Footprint

BODY_TYPES = ("static", "kinematic", "dynamic")


@dataclass(frozen=True)
class BodyConfig:
    """An entry of a model's `bodies`.

    Attributes:
        name: unique within the model.
        pose: in the model's frame.
        type: one of `BODY_TYPES`.
        color: of its footprints in rviz.
        linear_damping: [1/s].
        angular_damping: [1/s].
        footprints: its shapes.
        reader: of the entry, for warnings; None if a program has made it.
    """

    name: str
    pose: Pose
    type: str
    color: Color
    linear_damping: float
    angular_damping: float
    footprints: Tuple[Footprint, ...]
    reader: Optional[YamlReader] = field(default=None, compare=False, repr=False)

    @classmethod
    def read(cls, reader: YamlReader, registry: CollisionFilterRegistry) -> "BodyConfig":
        """Reads an entry; its `enabled` has been read.

        Args:
            reader: the reader of the entry.
            registry: the layers that footprints may name.

        Raises:
            YamlError: something in it is wrong.
        """
        body_type = reader.get_choice("type", BODY_TYPES, "dynamic")
        checker = _core.World().add_body(body_type, Pose())
        body = cls(
            name=reader.get_name("name"),
            pose=reader.get_pose("pose", Pose()),
            type=body_type,
            color=reader.get_color("color", (1.0, 1.0, 1.0, 0.5)),
            linear_damping=reader.get_float("linear_damping", 0.0, minimum=0.0),
            angular_damping=reader.get_float("angular_damping", 0.0, minimum=0.0),
            footprints=tuple(
                reader.get_sections(
                    "footprints",
                    lambda section: Footprint.read(section, registry, checker),
                    required=True,
                )
            ),
            reader=reader,
        )
        reader.finish()
        return body


class ModelBody:
    """A body of a model in the world.

    Args:
        config: the body's entry in the model file.
        model_pose: pose of the model's origin in the world [m, m, rad].
        physics: physical world to add the body to.

    Raises:
        ValueError: Box2D cannot represent a footprint; the world is unchanged.

    Attributes:
        config: its entry in the model file, with the footprints as they are now.
        physics_body: the body in the physical world.
    """

    def __init__(self, config: BodyConfig, model_pose: Pose, physics: _core.World) -> None:
        self.config = config
        self.physics_body = physics.add_body(
            config.type,
            model_pose.compose(config.pose),
            config.linear_damping,
            config.angular_damping,
        )
        try:
            for footprint in config.footprints:
                footprint.attach(self.physics_body)
        except BaseException:
            self.physics_body.remove()
            raise

    @property
    def name(self) -> str:
        """Its name, unique within the model."""
        return self.config.name

    @property
    def pose(self) -> Pose:
        """Pose of its origin in the world, the yaw within [-pi, pi]."""
        x, y, yaw = self.physics_body.pose
        return Pose(x, y, wrap_angle(yaw))

"""Models: robots, people, doors, boxes; collections of bodies, joints and plugins."""

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, List, Optional, Sequence, Tuple, TypeVar

from flatland_server import _core
from flatland_server.collision_filter_registry import CollisionFilterRegistry
from flatland_server.exceptions import ModelError, suggestion
from flatland_server.geometry import Pose
from flatland_server.joint import Joint, JointConfig
from flatland_server.model_body import BodyConfig, ModelBody
from flatland_server.plugin_config import PluginConfig, read_plugins
from flatland_server.yaml_reader import YamlReader

T = TypeVar("T")


@dataclass(frozen=True)
class ModelConfig:
    """A model file."""

    path: Path
    bodies: Tuple[BodyConfig, ...]
    joints: Tuple[JointConfig, ...]
    plugins: Tuple[PluginConfig, ...]

    @classmethod
    def from_file(cls, path: Path, registry: Optional[CollisionFilterRegistry]) -> "ModelConfig":
        """Reads a model file.

        Args:
            path: of the file.
            registry: the layers that footprints may name; None accepts every name.

        Raises:
            YamlError: something in it is wrong. What is in a plugin's entry is for the plugin to
                say, when it starts.
        """
        reader = YamlReader.from_file(path)
        bodies = _read_enabled(
            reader.get_sections("bodies", required=True),
            lambda section: BodyConfig.read(section, registry),
        )
        if not bodies:
            raise reader.error("expected at least one body, found none", "bodies")
        body_names = [body.name for body in bodies]
        joints = _read_enabled(
            reader.get_sections("joints"), lambda section: JointConfig.read(section, body_names)
        )
        plugins = read_plugins(reader)
        reader.finish()
        return cls(path, tuple(bodies), tuple(joints), tuple(plugins))


class Model:
    """A model in the world.

    Args:
        name: unique in the world.
        namespace: put before its topics and frames; may be empty.
        config: what its file says.
        pose: where its origin is put.
        physics: the world it is put in.
        registry: the collision layers of that world.

    Raises:
        ModelError: Box2D cannot take it.
    """

    def __init__(
        self,
        name: str,
        namespace: str,
        config: ModelConfig,
        pose: Pose,
        physics: _core.World,
        registry: CollisionFilterRegistry,
    ) -> None:
        self.name = name
        self.namespace = namespace.strip("/")
        self.config = config
        self.physics = physics
        self.registry = registry
        self.bodies: Dict[str, ModelBody] = {}
        self.joints: List[Joint] = []
        try:
            for body in config.bodies:
                self.bodies[body.name] = ModelBody(body, pose, physics)
            for joint in config.joints:
                self.joints.append(Joint(joint, self.bodies))
        except ValueError as error:
            self.remove()
            raise ModelError(f'the model "{name}" does not fit into the world: {error}') from None

    def get_body(self, name: str) -> ModelBody:
        """The body of that name.

        Raises:
            ModelError: there is none.
        """
        if name not in self.bodies:
            hint = suggestion(name, self.bodies)
            known = ", ".join(self.bodies)
            raise ModelError(f'the model has no body "{name}"{hint}; it has: {known}')
        return self.bodies[name]

    @property
    def base(self) -> ModelBody:
        """Its first body."""
        return next(iter(self.bodies.values()))

    @property
    def pose(self) -> Pose:
        """Where its origin is now, going by its first body."""
        return self.base.pose.compose(self.base.config.pose.inverse())

    def move(self, pose: Pose) -> None:
        """Puts it somewhere else as it is, its bodies as they stand to each other, at rest."""
        old = self.pose
        for body in self.bodies.values():
            body.physics_body.pose = pose.compose(old.inverse()).compose(body.pose)
            body.physics_body.halt()

    def remove(self) -> None:
        """Takes its bodies and joints out of the world."""
        for body in self.bodies.values():
            body.physics_body.remove()
        self.bodies.clear()
        self.joints.clear()

    def name_space_tf(self, frame_id: str) -> str:
        """A frame's name with this model's namespace: `<namespace>_<frame>`.

        A leading "/" keeps the namespace away, and is taken off.
        """
        if frame_id.startswith("/"):
            return frame_id[1:]
        return f"{self.namespace}_{frame_id}" if self.namespace else frame_id


def _read_enabled(sections: Sequence[YamlReader], read: Callable[[YamlReader], T]) -> List[T]:
    """The entries that are not switched off, each with a name of its own."""
    entries, names = [], set()
    for section in sections:
        if not section.get_bool("enabled", True):
            continue
        entries.append(read(section))
        name = section.get_string("name")
        if name in names:
            raise section.error(f'the name "{name}" is given twice', "name")
        names.add(name)
    return entries

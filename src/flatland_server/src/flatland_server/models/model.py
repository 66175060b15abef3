"""Models: robots, people, doors, boxes; collections of bodies, joints and plugins."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Optional, Tuple

from flatland_server import _core
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import ModelError, suggestion
from flatland_server.geometry import Pose
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.entity import Entities, Entity
from flatland_server.models.footprint import Circle
from flatland_server.models.joint import Joint, JointConfig
from flatland_server.models.model_body import BodyConfig, ModelBody
from flatland_server.models.plugin_config import PluginConfig


@dataclass(frozen=True)
class ModelConfig:
    """A model file."""

    path: Path
    bodies: Tuple[BodyConfig, ...]
    joints: Tuple[JointConfig, ...]
    plugins: Tuple[PluginConfig, ...]

    @classmethod
    def from_file(
        cls,
        path: Path,
        registry: CollisionFilterRegistry,
        preprocessor: Optional[YamlPreprocessor] = None,
    ) -> "ModelConfig":
        """Reads a model file.

        Args:
            path: of the file.
            registry: the layers that footprints may name.
            preprocessor: has the parameters for the file's expressions.

        Raises:
            YamlError: something in it is wrong. What is in a plugin's entry is for the plugin to
                say, when it starts.
        """
        return cls.read(YamlReader.from_file(path, preprocessor), registry)

    @classmethod
    def read(cls, reader: YamlReader, registry: CollisionFilterRegistry) -> "ModelConfig":
        """The same of a file that is being read already."""
        names: List[str] = []  # also of bodies that cannot be read: joints may name them

        def read_body(section: YamlReader) -> BodyConfig:
            names.append(section.get_string("name"))
            return BodyConfig.read(section, registry)

        bodies = reader.get_enabled_sections("bodies", read_body, required=True)
        if not bodies and reader.is_sound:
            reader.problem("expected at least one body, found none", "bodies")
        joints = reader.get_enabled_sections(
            "joints", lambda section: JointConfig.read(section, names)
        )
        plugins = reader.get_enabled_sections("plugins", PluginConfig.read)
        reader.finish()
        return cls(reader.file, tuple(bodies), tuple(joints), tuple(plugins))


class Model(Entity):
    """A model in the world.

    Args:
        name: unique in the world.
        namespace: put before its topics and frames; may be empty.
        config: what its file says.
        pose: where its origin is put.
        physics: the world it is put in.
        registry: the collision layers of that world.
        entities: who has a part in that world's contacts.

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
        entities: Entities,
    ) -> None:
        self._name = name
        self.namespace = namespace.strip("/")
        self.config = config
        self.physics = physics
        self.registry = registry
        self.entities = entities
        self.bodies: Dict[str, ModelBody] = {}
        self.joints: List[Joint] = []
        try:
            for body in config.bodies:
                self.bodies[body.name] = ModelBody(body, pose.wrapped(), physics)
            for joint in config.joints:
                self.joints.append(Joint(joint, self.bodies))
        except ValueError as error:
            self.remove()
            raise ModelError(f'the model "{name}" does not fit into the world: {error}') from None
        entities.add(self, self.physics_bodies)

    @property
    def name(self) -> str:
        """Its name, unique in the world."""
        return self._name

    @property
    def physics_bodies(self) -> List[_core.Body]:
        return [body.physics_body for body in self.bodies.values()]

    def body_name(self, fixture: _core.Fixture) -> str:
        for body in self.bodies.values():
            if body.physics_body == fixture.body:
                return body.name
        self._require_there()
        raise ModelError(f'the fixture is none of the model "{self.name}"')

    def _require_there(self) -> None:
        if not self.bodies:
            raise ModelError(f'the model "{self.name}" has been deleted')

    def get_body(self, name: str) -> ModelBody:
        """The body of that name.

        Raises:
            ModelError: there is none, or the model has been deleted.
        """
        if name not in self.bodies:
            self._require_there()
            hint = suggestion(name, self.bodies)
            known = ", ".join(self.bodies)
            raise ModelError(f'the model has no body "{name}"{hint}; it has: {known}')
        return self.bodies[name]

    def get_joint(self, name: str) -> Joint:
        """The joint of that name.

        Raises:
            ModelError: there is none, or the model has been deleted.
        """
        joints = {joint.name: joint for joint in self.joints}
        if name not in joints:
            self._require_there()
            hint = suggestion(name, joints)
            known = ", ".join(joints) or "none"
            raise ModelError(f'the model has no joint "{name}"{hint}; it has: {known}')
        return joints[name]

    @property
    def base(self) -> ModelBody:
        """Its first body.

        Raises:
            ModelError: the model has been deleted.
        """
        self._require_there()
        return next(iter(self.bodies.values()))

    @property
    def pose(self) -> Pose:
        """Where its origin is now, going by its first body."""
        return self.base.pose.compose(self.base.config.pose.inverse()).wrapped()

    @property
    def radius(self) -> float:
        """How far its footprints reach from its origin, with its joints as they are now [m]."""
        origin = self.pose[:2]
        reach = 0.0
        for body in self.bodies.values():
            for footprint in body.config.footprints:
                shape = footprint.shape
                radius = shape.radius if isinstance(shape, Circle) else 0.0
                for point in [shape.center] if isinstance(shape, Circle) else shape.vertices:
                    place = body.physics_body.world_point(point)
                    reach = max(reach, math.dist(origin, place) + radius)
        return reach

    def move(self, pose: Pose) -> None:
        """Puts it somewhere else as it is, its bodies as they stand to each other, at rest.

        Raises:
            ModelError: it cannot be there; it stays where it was.
        """
        displacement = pose.compose(self.pose.inverse()).wrapped()
        # The bodies' own poses, with all their turns: joints would feel a turn that only one makes.
        before = [
            (body.physics_body, Pose(*body.physics_body.pose)) for body in self.bodies.values()
        ]
        try:
            for body, old in before:
                body.pose = displacement.compose(old)
        except ValueError as error:
            for body, old in before:
                body.pose = old
            raise ModelError(f'the model "{self.name}" cannot be there: {error}') from None
        for body, _ in before:
            body.halt()

    def remove(self) -> None:
        """Takes its bodies and joints out of the world."""
        bodies = self.physics_bodies
        for body in bodies:
            body.remove()
        self.entities.remove(bodies)
        self.bodies.clear()
        self.joints.clear()

    def name_space_tf(self, frame_id: str) -> str:
        """A frame's name with this model's namespace: `<namespace>_<frame>`.

        A leading "/" keeps the namespace away, and is taken off.
        """
        if frame_id.startswith("/"):
            return frame_id[1:]
        return f"{self.namespace}_{frame_id}" if self.namespace else frame_id

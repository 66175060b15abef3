"""Models: robots, people, doors, boxes. A model consists of bodies, joints and plugins."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

from flatland_server import _core
from flatland_server.arguments import whole_number
from flatland_server.config.ros_names import bare_namespace, namespaced_frame
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import ModelError, listed, shortened, suggestion
from flatland_server.geometry import Pose
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.entity import Entities, Entity
from flatland_server.models.footprint import Circle, Polygon
from flatland_server.models.joint import Joint, JointConfig
from flatland_server.models.model_body import BodyConfig, ModelBody
from flatland_server.models.plugin_config import PluginConfig


class ModelText(NamedTuple):
    """The content of a model's file, as a text from a client."""

    text: str
    """YAML; see `YamlPreprocessor.read_text`."""
    name: str
    """The model's, for errors."""


@dataclass(frozen=True)
class ModelConfig:
    """The contents of a model file.

    Attributes:
        path: the file.
        bodies: its bodies, at least one; the first is the base.
        joints: its joints.
        plugins: its plugins, which read their own keys when they start.
        is_read: whether it was read from `path` or `content`; otherwise a program has made it.
        content: the plain data or the text that it was read from, if not a file.
        reader: of all that; None if a program has made it.
    """

    path: Path
    bodies: Tuple[BodyConfig, ...]
    joints: Tuple[JointConfig, ...]
    plugins: Tuple[PluginConfig, ...]
    is_read: bool = False
    content: Union[Mapping[str, Any], str, None] = field(default=None, compare=False, repr=False)
    reader: Optional[YamlReader] = field(default=None, compare=False, repr=False)

    @classmethod
    def from_file(
        cls,
        path: Path,
        registry: CollisionFilterRegistry,
        preprocessor: Optional[YamlPreprocessor] = None,
    ) -> "ModelConfig":
        """Reads a model file.

        Args:
            path: path of the model file.
            registry: the layers that footprints may name.
            preprocessor: evaluates the file's expressions, with their parameters.

        Raises:
            YamlError: something in it is wrong. Plugins check their own keys when they start.
        """
        return cls.read(YamlReader.from_file(path, preprocessor), registry)

    @classmethod
    def read(cls, reader: YamlReader, registry: CollisionFilterRegistry) -> "ModelConfig":
        """Reads a model from a file that is open in a reader; see `from_file`.

        Args:
            reader: the reader of the file.
            registry: the layers that footprints may name.
        """
        # In order, and also those of bodies that cannot be read: joints may name them.
        names: Dict[str, None] = {}

        def read_body(section: YamlReader) -> BodyConfig:
            names[section.get_string("name")] = None
            return BodyConfig.read(section, registry)

        bodies = reader.get_enabled_sections("bodies", read_body, required=True)
        if not bodies and reader.is_sound:
            reader.problem("expected at least one body, found none", "bodies")
        joints = reader.get_enabled_sections(
            "joints", lambda section: JointConfig.read(section, names)
        )
        plugins = reader.get_enabled_sections("plugins", PluginConfig.read)
        reader.finish()
        parts = tuple(bodies), tuple(joints), tuple(plugins)
        return cls(reader.file, *parts, is_read=True, reader=reader)


class Model(Entity):
    """A model in the world.

    Args:
        name: unique in the world.
        namespace: of its topics and frames; may be empty. A "~" before it makes the frame of its
            odometry one of its own, too, even if its file names it without "~".
        config: content of the model's file.
        pose: pose of its origin in the world [m, m, rad].
        physics: physical world to add the model to.
        registry: the collision layers of that world.
        entities: the entities of that world; the model adds itself.
        change: makes a change that ends contacts, now or at the end of the step; also gets the log
            message for a failure then.
        tf_by_namespace: as of `Transport`.

    Attributes:
        namespace: without a "/" at its ends, and without "~".
        has_own_frames: whether its namespace was given with "~".
        has_own_tf: whether its transforms are on topics of its namespace, and its frames' names
            without it.
        config: the contents of its file, with the footprints as they are now.
        bodies: by name, the base first; none after the model was deleted.
        joints: none after the model was deleted.
        move_revision: incremented by every `move`.
        footprint_revision: incremented by every change of a footprint.

    Raises:
        ModelError: Box2D cannot represent it.
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
        change: Callable[[Callable[[], None], str], None],
        tf_by_namespace: bool = False,
    ) -> None:
        self._name = name
        self.namespace = bare_namespace(namespace)
        self.has_own_tf = tf_by_namespace and bool(self.namespace)
        self.has_own_frames = namespace.startswith("~")
        self.config = config
        self.physics = physics
        self.registry = registry
        self.entities = entities
        self._change = change
        self.bodies: Dict[str, ModelBody] = {}
        self.joints: List[Joint] = []
        self.move_revision = 0
        self.footprint_revision = 0
        self._joints_by_name: Dict[str, Joint] = {}
        try:
            origin = pose.wrapped()
            for body in config.bodies:
                self.bodies[body.name] = ModelBody(body, origin, physics)
            for joint in config.joints:
                self.joints.append(Joint(joint, self.bodies))
                self._joints_by_name[joint.name] = self.joints[-1]
        except BaseException as error:
            self.remove()
            if not isinstance(error, ValueError):
                raise
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
        self._require_existing()
        raise ModelError(f'the fixture does not belong to the model "{self.name}"')

    def _require_existing(self) -> None:
        if not self.bodies:
            raise ModelError(f'the model "{self.name}" has been deleted')

    def get_body(self, name: str) -> ModelBody:
        """A body by its name.

        Args:
            name: the body's name.

        Raises:
            ModelError: there is none, or the model has been deleted.
        """
        if name not in self.bodies:
            self._require_existing()
            hint, known = suggestion(name, self.bodies), listed(self.bodies)
            raise ModelError(f'the model has no body "{shortened(name)}"{hint}; it has: {known}')
        return self.bodies[name]

    def get_joint(self, name: str) -> Joint:
        """A joint by its name.

        Args:
            name: the joint's name.

        Raises:
            ModelError: there is none, or the model has been deleted.
        """
        joints = self._joints_by_name
        if name not in joints:
            self._require_existing()
            hint, known = suggestion(name, joints), listed(joints)
            raise ModelError(f'the model has no joint "{shortened(name)}"{hint}; it has: {known}')
        return joints[name]

    @property
    def base(self) -> ModelBody:
        """The base: its first body.

        Raises:
            ModelError: the model has been deleted.
        """
        self._require_existing()
        return next(iter(self.bodies.values()))

    @property
    def pose(self) -> Pose:
        """The pose of its origin in the world, derived from the pose of its base."""
        return self.base.pose.compose(self.base.config.pose.inverse()).wrapped()

    @property
    def is_away(self) -> bool:
        """True for a recorded person who has not come yet, or has gone."""
        return self.base.pose.x >= _core.AWAY

    @property
    def radius(self) -> float:
        """The greatest distance [m] of a point of its footprints to its origin, as they are now."""
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

    def overlapping(self) -> List[Entity]:
        """The layers and other models that it overlaps, and that physics pushes it out of.

        Sensors, and footprints that do not collide with each other, do not count.
        """
        found: Dict[Entity, None] = {}
        for body in self.physics_bodies:
            for other in body.overlapping:
                owner = self.entities.find(other.id)
                if owner is not None and owner is not self:
                    found[owner] = None
        return list(found)

    def record_collisions(self) -> _core.BodyGroup:
        """Records the collisions of its bodies from now on; see `BodyGroup.last_collisions`."""
        group = _core.BodyGroup(self.physics_bodies)
        group.record_collisions()
        return group

    def move(self, pose: Pose) -> None:
        """Moves it as a rigid whole, and stops it.

        Args:
            pose: the new pose of its origin in the world.

        Raises:
            ModelError: Box2D cannot represent a body there; the model stays where it was.
        """
        displacement = pose.compose(self.pose.inverse()).wrapped()
        # With whole revolutions: joints compare the angles of their bodies without wrapping them.
        before = [
            (body.physics_body, Pose(*body.physics_body.pose)) for body in self.bodies.values()
        ]
        moved = []
        try:
            for body, old in before:
                body.pose = displacement.compose(old)
                moved.append((body, old))
        except ValueError as error:
            for body, old in moved:
                body.pose = old
            raise ModelError(f'the model "{self.name}" cannot be there: {error}') from None
        for body, _ in before:
            body.halt()
        self.move_revision += 1

    def set_footprint(
        self,
        body: str,
        index: int,
        shape: Optional[Union[Circle, Polygon]] = None,
        layers: Optional[Sequence[str]] = None,
    ) -> None:
        """Changes the shape or the layers of a footprint, until a reset.

        They are checked as those of a file are. The density stays, and the body's mass follows. The
        footprint's contacts end, and the next step finds the new ones; a body that is within it
        then is pushed out. In a plugin's hook, this happens at the end of the step; a failure is
        then logged.

        Args:
            body: the name of the body.
            index: of the footprint among the body's `footprints`, from 0.
            shape: in the body's frame [m]; None leaves it as it is.
            layers: names of its collision layers; None leaves them as they are.

        Raises:
            FlatlandError: there is no such footprint, or it cannot have this shape or these layers;
                nothing has changed.
        """
        footprints = self.get_body(body).config.footprints
        index = whole_number(index, "an index of a footprint", 0)
        if index >= len(footprints):
            count = f"it has {len(footprints)}, from index 0"
            raise ModelError(f'the body "{body}" has no footprint {index}; {count}')
        changes = footprints[index].changes(
            shape, layers, self.registry, f'the model "{self.name}"', f"{body}.footprints[{index}]"
        )
        self._change(
            lambda: self._set_footprint(body, index, changes),
            f'the model "{self.name}" keeps its footprint',
        )

    def _set_footprint(self, body: str, index: int, changes: Mapping[str, Any]) -> None:
        if not self.bodies:
            return  # it has been deleted meanwhile
        owner = self.bodies[body]
        footprints = list(owner.config.footprints)
        footprints[index] = replace(footprints[index], **changes)
        try:
            footprints[index].reshape(owner.physics_body.fixture(index))
        except ValueError as error:
            place = f'the body "{body}" of the model "{self.name}"'
            raise ModelError(f"{place} cannot have this footprint: {error}") from None
        owner.config = replace(owner.config, footprints=tuple(footprints))
        bodies = tuple(each.config for each in self.bodies.values())
        self.config = replace(self.config, bodies=bodies)
        self.footprint_revision += 1

    def remove(self) -> None:
        """Removes its bodies and joints from the world."""
        bodies = self.physics_bodies
        for body in bodies:
            body.remove()
        self.entities.remove(bodies)
        self.bodies.clear()
        self.joints.clear()
        self._joints_by_name.clear()

    def name_space_tf(self, frame_id: str) -> str:
        """The name of a frame of this model, with its namespace: `<namespace>_<frame>`.

        Without it if each namespace has transforms of its own (`tf_by_namespace`).

        Args:
            frame_id: the name without the namespace; a leading "/" is removed, and the namespace
                is then not added.
        """
        if frame_id.startswith("/"):
            return frame_id[1:]
        return frame_id if self.has_own_tf else namespaced_frame(self.namespace, frame_id)

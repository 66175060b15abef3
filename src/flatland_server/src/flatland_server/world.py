"""The world: layers, models and plugins, read from a file and moved step by step.

world = World.from_file(Path("world.yaml"))
timekeeper = Timekeeper(step_size=0.005)
world.step(timekeeper)
"""

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, List, Optional, Tuple

from flatland_server import _core
from flatland_server.collision_filter_registry import CollisionFilterRegistry
from flatland_server.enabled_entries import read_enabled
from flatland_server.exceptions import FlatlandError, ModelError, Problem, YamlError, suggestion
from flatland_server.geometry import Pose
from flatland_server.layer import Layer, LayerConfig
from flatland_server.local_transport import LocalTransport
from flatland_server.model import Model, ModelConfig
from flatland_server.model_plugin import ModelPlugin
from flatland_server.names import check_topic_name, namespace_problem, topic_name_problem
from flatland_server.node import Node, Transport
from flatland_server.plugin_config import PluginConfig
from flatland_server.plugin_loader import PluginLoader
from flatland_server.plugin_manager import PluginManager
from flatland_server.timekeeper import Timekeeper
from flatland_server.world_plugin import WorldPlugin
from flatland_server.yaml_preprocessor import YamlPreprocessor, is_file
from flatland_server.yaml_reader import YamlReader

_MOST_ITERATIONS = 10_000
"""Of the solver in a step; more would stall the simulation."""


@dataclass(frozen=True)
class ModelEntry:
    """An entry of a world's `models`, with the model's file."""

    name: str
    namespace: str
    pose: Pose
    model: ModelConfig


@dataclass(frozen=True)
class WorldConfig:
    """A world file with all the files that it names."""

    velocity_iterations: int
    position_iterations: int
    registry: CollisionFilterRegistry
    layers: Tuple[LayerConfig, ...]
    models: Tuple[ModelEntry, ...]
    plugins: Tuple[PluginConfig, ...]

    @classmethod
    def from_file(
        cls,
        path: Path,
        preprocessor: Optional[YamlPreprocessor] = None,
        *,
        simplify_map: int = 0,
    ) -> "WorldConfig":
        """Reads a world file and what it refers to; touches nothing else.

        Args:
            path: of the file.
            preprocessor: has the parameters for expressions in the files.
            simplify_map: how much the outlines of map images are simplified; see `read_map`.

        Raises:
            YamlError: something in the files is wrong; all that was found.
        """
        reader = YamlReader.from_file(path, preprocessor)
        return cls.read(reader, preprocessor, simplify_map=simplify_map)

    @classmethod
    def read(
        cls,
        reader: YamlReader,
        preprocessor: Optional[YamlPreprocessor] = None,
        *,
        simplify_map: int = 0,
    ) -> "WorldConfig":
        """The same of a file that is being read already."""
        properties = reader.get_section("properties", required=True)
        velocity_iterations = properties.get_int(
            "velocity_iterations", 10, minimum=1, maximum=_MOST_ITERATIONS
        )
        position_iterations = properties.get_int(
            "position_iterations", 10, minimum=1, maximum=_MOST_ITERATIONS
        )
        properties.finish()
        registry = CollisionFilterRegistry()
        layers = reader.get_sections(
            "layers",
            lambda section: LayerConfig.read(section, registry, preprocessor, simplify_map),
            required=True,
        )
        files: Dict[Path, ModelConfig] = {}  # each is read once, however many models there are

        def read_model(path: Path) -> ModelConfig:
            if path not in files:
                files[path] = ModelConfig.from_file(path, registry, preprocessor)
            return files[path]

        models = read_enabled(
            reader, "models", lambda section: _read_model_entry(section, read_model)
        )
        plugins = read_enabled(reader, "plugins", PluginConfig.read)
        reader.finish()
        return cls(
            velocity_iterations,
            position_iterations,
            registry,
            tuple(layers),
            tuple(models),
            tuple(plugins),
        )


def _read_model_entry(reader: YamlReader, read_model: Callable[[Path], ModelConfig]) -> ModelEntry:
    name = reader.get_string("name")
    check_topic_name(reader, "name", name)
    namespace = reader.get_string("namespace", "")
    problem = namespace_problem(namespace)
    if problem:
        reader.problem(problem, "namespace")
    pose = reader.get_pose("pose", Pose())
    path = reader.get_path("model")
    try:
        model = read_model(path) if is_file(path) else None
    except YamlError as error:
        reader.note(error)
        model = None
    reader.finish()
    assert model is not None  # or there was a problem
    return ModelEntry(name, namespace, pose, model)


class World:
    """All that lives in the simulation.

    Args:
        config: what the world's files say.
        transport: what carries its topics; by default this process alone.
        seed: of all chance in it. Equal seeds and commands give equal runs.
        loader: finds plugin classes; by default those on ROS_PACKAGE_PATH.

    Raises:
        FlatlandError: a model does not fit in, or a plugin does not start.
    """

    def __init__(
        self,
        config: WorldConfig,
        transport: Optional[Transport] = None,
        *,
        seed: int = 0,
        loader: Optional[PluginLoader] = None,
    ) -> None:
        self.transport: Transport = transport if transport is not None else LocalTransport()
        self.registry = config.registry
        self.models: Dict[str, Model] = {}
        self.physics = _core.World(config.velocity_iterations, config.position_iterations)
        self._plugins = PluginManager(Node(self.transport), loader or PluginLoader(), seed)
        self._is_stepping = False
        try:
            self.layers = [Layer(layer, self.physics) for layer in config.layers]
            problems: List[Problem] = []
            for entry in config.models:
                try:
                    self._add_model(entry)
                except YamlError as error:
                    problems.extend(error.problems)
            if problems:
                raise YamlError.of(problems)
            self._plugins.start(config.plugins, WorldPlugin, "", "", self)
        except BaseException:
            self.close()
            raise

    @classmethod
    def from_file(
        cls,
        path: Path,
        transport: Optional[Transport] = None,
        *,
        seed: int = 0,
        simplify_map: int = 0,
        loader: Optional[PluginLoader] = None,
    ) -> "World":
        """A world from its file; the class and `WorldConfig.from_file` say what can go wrong."""
        transport = transport if transport is not None else LocalTransport()
        with closing(YamlPreprocessor(transport.get_param)) as preprocessor:
            config = WorldConfig.from_file(path, preprocessor, simplify_map=simplify_map)
        return cls(config, transport, seed=seed, loader=loader)

    @property
    def plugin_count(self) -> int:
        """How many plugins live in it and its models."""
        return sum(len(self._plugins.plugins_of(owner)) for owner in ["", *self.models])

    def spawn_model(self, path: Path, name: str, namespace: str, pose: Pose) -> Model:
        """Puts a new model into the world: wholly, or not at all.

        Args:
            path: of the model file.
            name: unique in the world.
            namespace: of its topics and frames; may be empty.
            pose: where its origin is put.

        Raises:
            FlatlandError: the file, the name, the namespace or the pose is not usable; the world is
                then as it was.
        """
        problem = topic_name_problem(name) or namespace_problem(namespace)
        if problem:
            raise ModelError(problem)
        if name in self.models:
            raise ModelError(f'a model named "{name}" is already there')
        _check_pose(pose)
        if not is_file(path):
            raise ModelError(f"there is no file {path}")
        with closing(YamlPreprocessor(self.transport.get_param)) as preprocessor:
            config = ModelConfig.from_file(path, self.registry, preprocessor)
        return self._add_model(ModelEntry(name, namespace, pose, config))

    def delete_model(self, name: str) -> None:
        """Takes a model out of the world, with its topics and frames.

        Raises:
            ModelError: there is no such model.
        """
        model = self.get_model(name)
        self._require_between_steps()
        del self.models[name]
        self._plugins.stop(name)
        model.remove()

    def move_model(self, name: str, pose: Pose) -> None:
        """Puts a model somewhere else, at rest.

        Raises:
            ModelError: there is no such model, or the pose is not usable.
        """
        model = self.get_model(name)
        self._require_between_steps()
        _check_pose(pose)
        model.move(pose)

    def get_model(self, name: str) -> Model:
        """The model of that name.

        Raises:
            ModelError: there is none.
        """
        if name not in self.models:
            raise ModelError(f'there is no model "{name}"{suggestion(name, self.models)}')
        return self.models[name]

    def step(self, timekeeper: Timekeeper) -> None:
        """Moves the world and the timekeeper on by one step.

        Callbacks that wait are run by `transport.process()`, not here; `SimulationManager.step`
        does both.
        """
        self._is_stepping = True
        try:
            self._plugins.before_physics_step(timekeeper)
            self.physics.step(timekeeper.step_size)
            timekeeper.step()
            self._plugins.after_physics_step(timekeeper)
        finally:
            self._is_stepping = False
        self.transport.flush()

    def close(self) -> None:
        """Ends all plugins."""
        self._plugins.stop_all()

    def _add_model(self, entry: ModelEntry) -> Model:
        self._require_between_steps()
        model = Model(
            entry.name, entry.namespace, entry.model, entry.pose, self.physics, self.registry
        )
        self.models[entry.name] = model
        plugins = entry.model.plugins
        try:
            self._plugins.start(plugins, ModelPlugin, entry.name, entry.namespace, model)
        except BaseException:
            del self.models[entry.name]
            model.remove()
            raise
        return model

    def _require_between_steps(self) -> None:
        if self._is_stepping:
            raise FlatlandError("models come, go and are moved between steps, not during one")


def _check_pose(pose: Pose) -> None:
    if not pose.is_finite():
        raise ModelError(f"expected a finite pose, found x={pose.x} y={pose.y} theta={pose.yaw}")

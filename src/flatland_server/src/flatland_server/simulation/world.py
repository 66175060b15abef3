"""The world: layers, models and plugins, loaded from a file and simulated step by step.

world = World.from_file(Path("world.yaml"))
timekeeper = Timekeeper(step_size=0.005)
world.step(timekeeper)
"""

import logging
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Set, Tuple, Union

from flatland_server import _core
from flatland_server.arrays import Segments
from flatland_server.canvas import Canvas
from flatland_server.config.file_names import find_file, is_bare, nor_in
from flatland_server.config.input_files import is_file
from flatland_server.config.ros_names import namespace_problem, topic_name_problem
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import (
    FlatlandError,
    LayerError,
    ModelError,
    PluginError,
    Problem,
    YamlError,
    listed,
    shortened,
    suggestion,
)
from flatland_server.geometry import Pose
from flatland_server.models.entity import Entities
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model, ModelConfig
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.plugins.plugin_manager import FailureHandler, PluginFailure, PluginManager
from flatland_server.simulation.additions import Additions
from flatland_server.simulation.deferred_actions import DeferredActions
from flatland_server.simulation.load_progress import LoadProgress
from flatland_server.simulation.restartable import Restartable
from flatland_server.simulation.stepping import Stepping
from flatland_server.simulation.world_config import ModelEntry, WorldConfig
from flatland_server.simulation.world_plugin import WorldPlugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.transport import Transport

logger = logging.getLogger(__name__)

ModelSource = Union[str, Path, Mapping[str, Any]]
"""A model's file, or its content."""


class World(Restartable, Stepping):
    """The layers, models and plugins of a simulation, and the physics that moves them.

    Args:
        config: the contents of the world's files.
        transport: carries topics, transforms and parameters; by default within this process alone.
        seed: of all random numbers. Equal seeds and commands give equal runs.
        loader: finds plugin classes; by default those on ROS_PACKAGE_PATH.

    Raises:
        FlatlandError: a model cannot be created, or a plugin does not start.
    """

    def __init__(
        self,
        config: WorldConfig,
        transport: Optional[Transport] = None,
        *,
        seed: int = 0,
        loader: Optional[PluginLoader] = None,
    ) -> None:
        self._on_failure: Optional[FailureHandler] = None
        self.transport: Transport = transport if transport is not None else LocalTransport()
        self._loader = loader or PluginLoader()
        self._start(config, seed)

    def _start(self, config: WorldConfig, seed: int) -> None:
        """Makes all that the world consists of, in place of what there was."""
        former: Optional[PluginManager] = getattr(self, "_plugins", None)
        physics = _core.World(config.velocity_iterations, config.position_iterations)
        entities = Entities()
        plugins = PluginManager(self.transport, self._loader, seed, physics, entities)
        plugins.on_failure = self._on_failure
        if former is not None:
            plugins.take_over_warnings(former)
        self._config = config
        self._seed = seed
        self.registry = config.registry
        self._model_folders = config.model_folders
        self.models: Dict[str, Model] = {}
        """By name."""
        self.physics = physics
        """The Box2D world, in the core."""
        self.entities = entities
        """The model or layer that each body belongs to."""
        self.layers: List[Layer] = []
        self._plugins = plugins
        self._deferred = DeferredActions()
        self._additions = Additions()
        self._is_starting = True
        try:
            self._add_layers(config)
            problems: List[Problem] = []
            for entry in config.models:
                try:
                    self.add_model(entry)
                except YamlError as error:
                    problems.extend(error.problems)
            if problems:
                raise YamlError.of(problems)
            self._plugins.start(config.plugins, WorldPlugin, "", "", self)
        except BaseException:
            self.close()
            raise
        self._is_starting = False

    def _add_layers(self, config: WorldConfig) -> None:
        progress = LoadProgress(sum(len(config.walls_of(layer)) for layer in config.layers))
        for layer in config.layers:
            walls = config.walls_of(layer)
            self.layers.append(Layer(layer, walls, self.physics, self.entities, progress.update))
            progress.layer_is_complete(len(walls))

    @classmethod
    def from_file(
        cls,
        path: Path,
        transport: Optional[Transport] = None,
        *,
        seed: int = 0,
        simplify_map: int = 0,
        loader: Optional[PluginLoader] = None,
        model_folders: Sequence[Path] = (),
    ) -> "World":
        """Loads a world file.

        Args:
            path: of the file.
            transport: as for the class.
            seed: as for the class.
            simplify_map: how much the outlines of map images are simplified; see `read_map`.
            loader: as for the class.
            model_folders: where model files are looked up that are not beside the world file, also
                those that are spawned later.

        Raises:
            YamlError: something in the files is wrong; lists everything that was found.
            FlatlandError: a model cannot be created, or a plugin does not start.
        """
        transport = transport if transport is not None else LocalTransport()
        with closing(YamlPreprocessor(transport.get_param)) as preprocessor:
            config = WorldConfig.from_file(
                path, preprocessor, simplify_map=simplify_map, model_folders=model_folders
            )
        return cls(config, transport, seed=seed, loader=loader)

    @property
    def plugin_count(self) -> int:
        """The number of plugins of the world and its models, including those that have failed."""
        return sum(len(self._plugins.plugins_of(owner)) for owner in ["", *self.models])

    @property
    def odometry_frames(self) -> Set[str]:
        """The frames from which drives publish transforms to their bodies, such as "odom"."""
        return self._plugins.odometry_frames

    @property
    def seed(self) -> int:
        """The seed of all random numbers."""
        return self._seed

    @property
    def config(self) -> WorldConfig:
        """The contents of its files."""
        return self._config

    @property
    def on_failure(self) -> Optional[FailureHandler]:
        """Called with the failure of a plugin and its exception; None: failures are logged."""
        return self._on_failure

    @on_failure.setter
    def on_failure(self, handler: Optional[FailureHandler]) -> None:
        self._on_failure = self._plugins.on_failure = handler

    @property
    def is_between_steps(self) -> bool:
        """Whether no step is being made, and no plugin is being started or stopped."""
        return self._deferred.is_free and not self._is_starting

    @property
    def topics(self) -> Dict[str, str]:
        """The types of the topics that plugins publish or subscribe to, by their absolute names."""
        return self._plugins.topics

    def publish_now(self, topic: str, timekeeper: Timekeeper) -> None:
        """Has plugins publish to a topic, which has just got its first subscriber.

        Args:
            topic: its absolute name.
            timekeeper: has the present time.
        """
        self._plugins.publish_now(topic, timekeeper)

    def plugins_of(self, model: str) -> Dict[str, Plugin]:
        """The plugins of a model that run, by name; of the world for an empty name."""
        return {
            plugin.name: plugin
            for plugin in self._plugins.plugins_of(model)
            if self._plugins.failure_of(plugin) is None
        }

    def all_plugins_of(self, model: str) -> List[Tuple[Plugin, bool]]:
        """The plugins of a model, each with whether it was switched off because of an error."""
        return [
            (plugin, self._plugins.failure_of(plugin) is not None)
            for plugin in self._plugins.plugins_of(model)
        ]

    @property
    def plugin_revision(self) -> int:
        """Another value whenever `plugins_of` may give something else for a model."""
        return self._plugins.revision

    @property
    def plugin_failures(self) -> List[PluginFailure]:
        """The plugins that have raised an exception and are switched off."""
        return self._plugins.failures

    def draw_plugins(self, canvas: Canvas, timekeeper: Timekeeper) -> None:
        """Has all running plugins draw what they show in pictures; see `Plugin.draw`."""
        self._plugins.draw(canvas, timekeeper)

    def spawn_model(
        self, path: ModelSource, name: str, namespace: str, pose: Pose
    ) -> Optional[Model]:
        """Adds a model, read from its file, to the world: completely, or not at all.

        In a plugin's hook, the model is added at the end of the step; a failure is then logged. A
        model within a wall or another model is a warning in the log; see `overlap_warning`.

        Args:
            path: of the model file; `package://name/path` as a string. A relative one may also be
                beside the world file, or in one of the folders of models. Or the content of such a
                file, as a dict.
            name: unique in the world.
            namespace: of its topics and frames; may be empty.
            pose: of its origin in the world.

        Returns:
            The model; None if it is added later.

        Raises:
            FlatlandError: the file, the name, the namespace or the pose is not usable. The world is
                unchanged.
        """
        entry = self.read_model_entry(path, name, namespace, pose)
        return self._deferred.run_or_defer(
            lambda: self._spawn(entry), f'the model "{name}" is not spawned'
        )

    def overlap_warning(self, model: Model) -> str:
        """What to tell the user about a model that was put within walls or other models.

        Returns:
            A sentence that names what it overlaps; empty if it overlaps nothing.
        """
        entities = model.overlapping()
        if not entities:
            return ""
        names = [
            f'the {"layer" if isinstance(entity, Layer) else "model"} "{entity.name}"'
            for entity in entities
        ]
        return f'the model "{model.name}" overlaps {listed(names)}, and is pushed out'

    def read_model(self, path: ModelSource) -> ModelConfig:
        """Reads a model file, or the content of one, for this world; may be called in any thread.

        Raises:
            FlatlandError: there is no such file, or something in it is wrong.
        """
        if not isinstance(path, (str, Path)):
            with closing(YamlPreprocessor(self.transport.get_param)) as preprocessor:
                return ModelConfig.from_content(path, self.registry, preprocessor)
        folders = self._model_folders if is_bare(path) else ()
        try:
            found = find_file(path, [Path(), *folders])
        except FlatlandError as error:
            raise ModelError(str(error)) from None
        if not is_file(found):
            raise ModelError(f"there is no file {found}{nor_in(folders)}")
        with closing(YamlPreprocessor(self.transport.get_param)) as preprocessor:
            return ModelConfig.from_file(found, self.registry, preprocessor)

    def read_model_entry(
        self, path: ModelSource, name: str, namespace: str, pose: Pose
    ) -> ModelEntry:
        """Does all of `spawn_model` that does not change the world; any thread may call it.

        The result is for `add_model`, which checks again that the name is free. Plugin classes are
        imported here, so that `add_model` does not have to.

        Args: those of `spawn_model`.

        Raises:
            FlatlandError: the file, the name, the namespace or the pose is not usable.
        """
        problem = topic_name_problem(name) or namespace_problem(namespace)
        if problem:
            raise ModelError(problem)
        self._check_name_is_free(name)
        _check_pose(pose)
        model = self.read_model(path)
        for plugin in model.plugins:
            with suppress(PluginError):  # add_model reports it, with its line
                self._loader.load(plugin.type, ModelPlugin)
        return ModelEntry(name, namespace, pose, model)

    def add_model(self, entry: ModelEntry) -> Model:
        """Adds a model that has been read already, or made without a file, to the world.

        Raises:
            FlatlandError: its name is taken, its bodies cannot be created, or one of its plugins
                does not start: the world is unchanged. Or a step is being made.
        """
        if self._deferred.is_locked:
            raise FlatlandError(
                "add_model is for between steps; spawn_model may be called in a hook"
            )
        self._check_name_is_free(entry.name)
        model = Model(
            entry.name,
            entry.namespace,
            entry.model,
            entry.pose,
            self.physics,
            self.registry,
            self.entities,
        )
        self.models[entry.name] = model
        with self._deferred.changing(entry.name):
            plugins = entry.model.plugins
            try:
                self._plugins.start(plugins, ModelPlugin, entry.name, entry.namespace, model)
            except BaseException:
                in_order = list(self.models.values())
                del self.models[entry.name]
                self._remove_bodies(model)
                for other in in_order[in_order.index(model) + 1 :]:
                    self._remove(other)  # spawned by the plugins of the one that has failed
                raise
        self._additions.add_model(entry, self._comes_with_another)
        self._deferred.run_pending()
        return model

    @property
    def _comes_with_another(self) -> bool:
        """Whether making the world or a model again adds again what is added now."""
        return self._is_starting or self._plugins.is_starting

    def delete_model(self, name: str) -> None:
        """Removes a model from the world, with its topics and frames.

        In a plugin's hook, this happens at the end of the step.

        Raises:
            ModelError: there is no such model.
        """
        model = self.get_model(name)
        self._deferred.run_or_defer(
            lambda: self._remove(model),
            f'the model "{name}" is not deleted',
            unless_changing=name,
        )

    def move_model(self, name: str, pose: Pose) -> None:
        """Puts a model at another pose, at rest.

        In a plugin's hook, this happens at the end of the step; a failure is then logged.

        Raises:
            ModelError: there is no such model, or the pose is not usable.
        """
        model = self.get_model(name)
        _check_pose(pose)
        self._deferred.run_or_defer(
            lambda: self._move(model, pose), f'the model "{name}" is not moved'
        )

    def add_walls(self, layer: str, segments: Segments) -> None:
        """Adds walls to a layer.

        Args:
            layer: one of its names.
            segments: in the world [m]: shape (n, 4), x1, y1, x2, y2.

        Raises:
            LayerError: there is no such layer.
            FlatlandError: a step is being made.
            ValueError: a segment is not finite, or has no length.
        """
        if self._deferred.is_locked:
            raise FlatlandError("walls are put up between steps, not during one")
        found = self.get_layer(layer)
        found.add_walls(segments)
        if not self._comes_with_another:
            self._additions.add_walls(self.layers.index(found), segments)
        self._plugins.refresh(found)

    def get_layer(self, name: str) -> Layer:
        """The layer that has this name, perhaps among others.

        Raises:
            LayerError: there is no such layer.
        """
        for layer in self.layers:
            if name in layer.config.names:
                return layer
        hint = suggestion(name, self.registry.names)
        known = listed(self.registry.names)
        raise LayerError(f'no layer is named "{shortened(name)}"{hint}; there are: {known}')

    def get_model(self, name: str) -> Model:
        """The model of this name.

        Raises:
            ModelError: there is no such model.
        """
        if name not in self.models:
            hint = suggestion(name, self.models)
            raise ModelError(f'there is no model "{shortened(name)}"{hint}')
        return self.models[name]

    def close(self) -> None:
        """Stops all plugins. Changes that they request meanwhile are dropped."""
        try:
            with self._deferred.lock:
                self._plugins.stop_all()
        finally:
            self._deferred.clear()

    def _spawn(self, entry: ModelEntry) -> Model:
        model = self.add_model(entry)
        warning = self.overlap_warning(model)
        if warning:
            logger.warning("%s", warning)
        return model

    def _check_name_is_free(self, name: str) -> None:
        if name in self.models:
            raise ModelError(f'a model named "{name}" is already there')

    def _remove(self, model: Model) -> None:
        if not self._has(model):
            return
        with self._deferred.changing(model.name):
            try:
                self._plugins.stop(model.name)
            finally:
                del self.models[model.name]
                self._additions.remove_model(model.name)
                self._remove_bodies(model)

    def _remove_bodies(self, model: Model) -> None:
        with self._deferred.lock:  # it ends contacts, which calls hooks
            model.remove()

    def _move(self, model: Model, pose: Pose) -> None:
        if self._has(model):
            model.move(pose)

    def _has(self, model: Model) -> bool:
        """Whether a model is still there; it may be deleted before a deferred action runs."""
        return self.models.get(model.name) is model


def _check_pose(pose: Pose) -> None:
    if not pose.is_finite():
        raise ModelError(f"expected a finite pose, found x={pose.x} y={pose.y} theta={pose.yaw}")

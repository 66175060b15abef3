"""The world: layers, models and plugins, loaded from a file and simulated step by step.

world = World.from_file(Path("world.yaml"))
timekeeper = Timekeeper(step_size=0.005)
world.step(timekeeper)
"""

from contextlib import closing
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Set, Tuple

from flatland_server import _core
from flatland_server.arrays import Segments
from flatland_server.canvas import Canvas
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import (
    FlatlandError,
    LayerError,
    Problem,
    YamlError,
    listed,
    shortened,
    suggestion,
)
from flatland_server.models.entity import Entities
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.plugins.plugin_manager import (
    FailureHandler,
    PluginFailure,
    PluginManager,
    PluginRevision,
)
from flatland_server.simulation.additions import Additions
from flatland_server.simulation.deferred_actions import DeferredActions
from flatland_server.simulation.load_progress import LoadProgress
from flatland_server.simulation.restartable import Restartable
from flatland_server.simulation.spawning import Spawning
from flatland_server.simulation.stepping import Stepping
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.simulation.world_plugin import WorldPlugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.transport import Transport


class World(Spawning, Restartable, Stepping):
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
        self.plugin_revision = PluginRevision()
        """Changes whenever `plugins_of` may give something else for a model."""
        self.transport: Transport = transport if transport is not None else LocalTransport()
        self._loader = loader or PluginLoader()
        self._start(config, seed)

    def _start(self, config: WorldConfig, seed: int) -> None:
        """Makes all that the world consists of, in place of what there was."""
        former: Optional[PluginManager] = getattr(self, "_plugins", None)
        physics = _core.World(config.velocity_iterations, config.position_iterations)
        entities = Entities()
        revision = self.plugin_revision
        plugins = PluginManager(self.transport, self._loader, seed, physics, entities, revision)
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
        self.plan = plugins.plan
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
        """The plugins of a model that run, by name.

        Args:
            model: its name; empty for the plugins of the world.
        """
        return {
            plugin.name: plugin
            for plugin in self._plugins.plugins_of(model)
            if self._plugins.failure_of(plugin) is None
        }

    def all_plugins_of(self, model: str) -> List[Tuple[Plugin, bool]]:
        """The plugins of a model, each with whether it was switched off because of an error.

        Args:
            model: its name; empty for the plugins of the world.
        """
        return [
            (plugin, self._plugins.failure_of(plugin) is not None)
            for plugin in self._plugins.plugins_of(model)
        ]

    @property
    def plugin_failures(self) -> List[PluginFailure]:
        """The plugins that have raised an exception and are switched off."""
        return self._plugins.failures

    def draw_plugins(self, canvas: Canvas, timekeeper: Timekeeper) -> None:
        """Has all running plugins draw what they show in pictures; see `Plugin.draw`.

        Args:
            canvas: the picture.
            timekeeper: has the time.
        """
        self._plugins.draw(canvas, timekeeper)

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

        Args:
            name: one of its names.

        Raises:
            LayerError: there is no such layer.
        """
        for layer in self.layers:
            if name in layer.config.names:
                return layer
        hint = suggestion(name, self.registry.names)
        known = listed(self.registry.names)
        raise LayerError(f'no layer is named "{shortened(name)}"{hint}; there are: {known}')

    def close(self) -> None:
        """Stops all plugins. Changes that they request meanwhile are dropped."""
        try:
            with self._deferred.lock:
                self._plugins.stop_all()
        finally:
            self._deferred.clear()

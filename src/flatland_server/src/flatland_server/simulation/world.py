"""The world: layers, models and plugins, loaded from a file; a `Run` steps it.

run = Run(World.from_file(Path("world.yaml")), Timekeeper(step_size=0.005))
run.step()
"""

import logging
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Callable, Dict, List, Optional, Sequence, Set, Tuple

import numpy as np

from flatland_server import _core
from flatland_server.arrays import PoseLike, Segments
from flatland_server.config.ros_names import namespace_problem, topic_name_problem
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import (
    FlatlandError,
    LayerError,
    ModelError,
    PluginError,
    UsageError,
    listed,
    shortened,
    suggestion,
    unknown,
)
from flatland_server.geometry import Pose
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.entity import Entities
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model, ModelConfig
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginLoader, shared_loader
from flatland_server.plugins.plugin_manager import PluginFailure, PluginRevision
from flatland_server.simulation import plugin_state
from flatland_server.simulation.load_warnings import warn_of_sensors, warn_of_traps
from flatland_server.simulation.world_config import ModelEntry, ModelSource, WorldConfig
from flatland_server.simulation.world_contents import WorldContents
from flatland_server.transport.claims import OdometryFrame
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.node import Node
from flatland_server.transport.transport import Transport

logger = logging.getLogger(__name__)


class World:
    """The layers, models and plugins of a simulation, and the physics that moves them.

    Between two steps its contents may be replaced as a whole, by a reset or a reload. New contents
    are made while the former ones still exist. If this fails, those are kept; otherwise their
    plugins are shut down afterwards. So topics that both have keep their connections.

    Args:
        config: contents of the world's files.
        transport: carries topics, transforms and parameters; by default within this process alone.
        seed: of all random numbers. Equal seeds and commands give equal runs.
        loader: finds plugin classes; by default those on ROS_PACKAGE_PATH.

    Attributes:
        contents: all that a reset makes anew.
        plugin_revision: changes whenever the result of `plugins_of` may change.
        transport: carries topics, transforms and parameters.

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
        self.plugin_revision = PluginRevision()
        self.transport: Transport = transport if transport is not None else LocalTransport()
        self._loader = loader or shared_loader()
        self.contents = WorldContents(
            config, seed, self.transport, self._loader, self.plugin_revision
        )
        try:
            self._start()
        except BaseException:
            self.contents.discard()
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
        model_folders: Sequence[Path] = (),
    ) -> "World":
        """Loads a world file.

        Args:
            path: path of the world file.
            transport: as for the class.
            seed: as for the class.
            simplify_map: how much the outlines of map images are simplified; see `MapConfig.walls`.
            loader: as for the class.
            model_folders: where model files are looked up that are not beside the world file, also
                those that are spawned later.

        Raises:
            YamlError: something in the files is wrong; lists everything that was found.
            FlatlandError: a model cannot be created, or a plugin does not start.
        """
        transport = transport if transport is not None else LocalTransport()
        preprocessor = YamlPreprocessor(transport.get_param, seed)
        config = WorldConfig.from_file(
            path, preprocessor, simplify_map=simplify_map, model_folders=model_folders
        )
        return cls(config, transport, seed=seed, loader=loader)

    def twin(self, transport: Transport) -> "World":
        """Another world of the same files and plugin classes, as it is after a reset.

        Args:
            transport: the other world's transport.
        """
        return World(self.config, transport, seed=self.seed, loader=self._loader)

    def _start(self) -> None:
        """Adds the layers and models of the files, and starts all plugins."""
        contents = self.contents
        contents.add_layers_and_models()
        contents.plugins.start(contents.config.plugins, WorldPlugin, "", "", self)
        contents.is_changing = False
        warn_of_traps(contents)

    # Contents

    @property
    def config(self) -> WorldConfig:
        """The contents of its files."""
        return self.contents.config

    @property
    def seed(self) -> int:
        """The seed of all random numbers."""
        return self.contents.seed

    @property
    def registry(self) -> CollisionFilterRegistry:
        """Its collision layers."""
        return self.contents.config.registry

    @property
    def physics(self) -> _core.World:
        """The Box2D world, in the core."""
        return self.contents.physics

    @property
    def entities(self) -> Entities:
        """The model or layer that each body belongs to."""
        return self.contents.entities

    @property
    def layers(self) -> List[Layer]:
        """The layers, in the order of the world file."""
        return self.contents.layers

    @property
    def models(self) -> Dict[str, Model]:
        """The models by name, in the order of their creation."""
        return self.contents.models

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
        raise LayerError(unknown("no layer is named", name, self.registry.names))

    def get_model(self, name: str) -> Model:
        """The model of this name.

        Args:
            name: the model's name.

        Raises:
            ModelError: there is no such model.
        """
        models = self.contents.models
        if name not in models:
            hint = suggestion(name, models)
            raise ModelError(f'there is no model "{shortened(name)}"{hint}')
        return models[name]

    # Changes of models and walls

    def spawn_model(
        self, path: ModelSource, name: str, namespace: str, pose: PoseLike
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
            pose: x, y [m] and yaw [rad] of its origin in the world.

        Returns:
            The model; None if it is added later.

        Raises:
            FlatlandError: the file, the name, the namespace or the pose is not usable. The world is
                unchanged.
        """
        entry = self.read_model_entry(path, name, namespace, pose)
        return self.contents.deferred.run_or_defer(
            lambda: self._spawn(entry), f'the model "{name}" is not spawned'
        )

    def _spawn(self, entry: ModelEntry) -> Model:
        model = self.add_model(entry)
        warning = self.overlap_warning(model)
        if warning:
            logger.warning("%s", warning)
        return model

    def read_model(self, path: ModelSource) -> ModelConfig:
        """Reads a model file, or the content of one, for this world; may be called in any thread.

        Args:
            path: of the file, or the content of one as a dict.

        Raises:
            FlatlandError: there is no such file, or something in it is wrong.
        """
        preprocessor = YamlPreprocessor(self.transport.get_param, self.seed)
        return self.config.read_model(path, preprocessor)

    def read_model_entry(
        self, path: ModelSource, name: str, namespace: str, pose: PoseLike
    ) -> ModelEntry:
        """Does all of `spawn_model` that does not change the world; any thread may call it.

        The result is for `add_model`, which checks again that the name is free. Plugin classes are
        imported here, so that `add_model` does not have to.

        Args:
            path: as for `spawn_model`.
            name: as for `spawn_model`.
            namespace: as for `spawn_model`.
            pose: as for `spawn_model`.

        Raises:
            FlatlandError: the file, the name, the namespace or the pose is not usable.
        """
        problem = topic_name_problem(name) or namespace_problem(namespace)
        if problem:
            raise ModelError(problem)
        self.contents.check_name_is_free(name)
        place = _pose_of(pose)
        model = self.read_model(path)
        for plugin in model.plugins:
            with suppress(PluginError):  # add_model reports it, with its line
                self._loader.load(plugin.type, ModelPlugin)
        return ModelEntry(name, namespace, place, model)

    def add_model(self, entry: ModelEntry) -> Model:
        """Adds a model that has been read already, or made without a file, to the world.

        Args:
            entry: result of `read_model_entry`, or an entry made by a program.

        Raises:
            FlatlandError: its name is taken, its bodies cannot be created, or one of its plugins
                does not start: the world is unchanged. Or a step is being made.
        """
        if self.contents.deferred.is_locked:
            raise FlatlandError(
                "add_model is for between steps; spawn_model may be called in a hook"
            )
        self.contents.deferred.revision += 1
        model = self.contents.add_model(entry)
        warn_of_sensors(entry.model, self.contents.plugins.plugins_of(entry.name))
        return model

    def overlap_warning(self, model: Model) -> str:
        """A warning for a model that was put within walls or other models.

        Args:
            model: a model of this world.

        Returns:
            A sentence that names what it overlaps; empty if it overlaps nothing.
        """
        entities = model.overlapping()
        if not entities:
            return ""
        names = listed([each.description for each in entities])
        return f"{model.description} overlaps {names}, and is pushed out"

    def delete_model(self, name: str) -> None:
        """Removes a model from the world, with its topics and frames.

        In a plugin's hook, this happens at the end of the step.

        Args:
            name: the model's name.

        Raises:
            ModelError: there is no such model.
        """
        contents, model = self.contents, self.get_model(name)
        contents.deferred.run_or_defer(
            lambda: contents.remove_model(model),
            f'the model "{name}" is not deleted',
            unless_changing=name,
        )

    def move_model(self, name: str, pose: PoseLike) -> None:
        """Puts a model at another pose, at rest.

        In a plugin's hook, this happens at the end of the step; a failure is then logged.

        Args:
            name: the model's name.
            pose: x, y [m] and yaw [rad] of its origin in the world.

        Raises:
            FlatlandError: there is no such model, or the pose is not usable.
        """
        contents, model = self.contents, self.get_model(name)
        place = _pose_of(pose)
        contents.deferred.run_or_defer(
            lambda: model.move(place) if contents.has(model) else None,
            f'the model "{name}" is not moved',
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
        if self.contents.deferred.is_locked:
            raise FlatlandError("walls are put up between steps, not during one")
        self.contents.deferred.revision += 1
        self.contents.add_walls(self.get_layer(layer), segments)

    # New contents

    @property
    def is_between_steps(self) -> bool:
        """True if no step is being made, and no plugin is being started or stopped."""
        return self.contents.deferred.defers_nothing and not self.contents.is_changing

    def require_between_steps(self, name: str) -> None:
        """Checks that no step is being made, and no plugin is being started or stopped.

        Args:
            name: name of the calling function, for the error.

        Raises:
            FlatlandError: otherwise.
        """
        if not self.is_between_steps:
            raise FlatlandError(f"{name} is for between steps, not for hooks or for other threads")

    def reset(self, seed: Optional[int] = None) -> None:
        """Rebuilds the world as it was loaded: its models, plugins, walls and random numbers.

        The run from then on equals, bit for bit, that of a newly loaded world. No file is read:
        with another seed, expressions with math.random are evaluated again as they were. Models and
        plugins are new objects, and the former ones are gone; topics stay connected.

        In a plugin's hook, this happens at the end of the step; a failure is then logged. Changes
        requested after it in the same step fail.

        Args:
            seed: of all random numbers from now on; None is the same as before.

        Raises:
            FlatlandError: a plugin does not start again, or this is called in `on_initialize` or
                `on_shutdown`. The world is unchanged.
        """
        contents = self.contents
        deferred = contents.deferred
        if contents.is_changing or not (deferred.defers_nothing or deferred.is_locked):
            raise FlatlandError("the world cannot be reset while plugins are started or stopped")
        chosen = contents.seed if seed is None else seed
        deferred.run_or_defer(
            lambda: self.rebuild(contents.config, chosen), "the world is not reset"
        )

    def read_config(self, path: Optional[Path] = None) -> WorldConfig:
        """Reads a world's files, for `Run.reload`; may be called in any thread.

        Args:
            path: of the world file; None reads this world's own again.

        Raises:
            FlatlandError: something in them is wrong, or the world was made without a file.
        """
        read_at = time.monotonic()
        preprocessor = YamlPreprocessor(self.transport.get_param, self.seed)
        return replace(self.config.read_again(path, preprocessor), read_at=read_at)

    def rebuild(
        self, config: WorldConfig, seed: int, restore: Callable[[], None] = lambda: None
    ) -> None:
        """Replaces all contents, between two steps; for `Run`.

        Args:
            config: contents of the files to build from.
            seed: the seed of the new contents.
            restore: called when these have started, before the former ones are gone.

        Raises:
            FlatlandError: a model or plugin does not start, or `restore` raises it. The world is
                unchanged.
        """
        former = self.contents
        new = WorldContents(
            config, seed, self.transport, self._loader, self.plugin_revision, former
        )
        self.contents = new
        try:
            self._start()
            restore()
        except BaseException:
            new.discard()
            self.contents = former
            raise
        self.contents = former  # so that its plugins shut down in their own world
        former.deferred.drop("the world has been reset before")
        former.discard()
        self.contents = new
        self.transport.discard()

    def close(self) -> None:
        """Stops all plugins. Changes that they request meanwhile are dropped."""
        self.contents.close()

    # Plugins

    @property
    def topics(self) -> Dict[str, str]:
        """The types of the topics that plugins publish or subscribe to, by their absolute names."""
        return self.contents.plugins.topics.types

    @property
    def odometry_frames(self) -> Set[OdometryFrame]:
        """The frames from which drives publish transforms to their bodies, such as "odom"."""
        return self.contents.plugins.frames.odometry_frames

    @property
    def plugin_count(self) -> int:
        """The number of plugins of the world and its models, including those that have failed."""
        return len(self.contents.plugins.all_plugins())

    def plugins_of(self, model: str) -> Dict[str, Plugin]:
        """The plugins of a model that run, by name.

        Args:
            model: its name; empty for the plugins of the world.
        """
        return {
            plugin.name: plugin
            for plugin, has_failed in self.all_plugins_of(model)
            if not has_failed
        }

    def all_plugins_of(self, model: str) -> List[Tuple[Plugin, bool]]:
        """The plugins of a model, each with whether it was switched off because of an error.

        Args:
            model: its name; empty for the plugins of the world.
        """
        plugins = self.contents.plugins
        return [
            (plugin, plugins.failure_of(plugin) is not None) for plugin in plugins.plugins_of(model)
        ]

    @property
    def plugin_failures(self) -> List[PluginFailure]:
        """The plugins that have raised an exception and are switched off."""
        return self.contents.plugins.failures

    @property
    def plugins_without_state_hooks(self) -> List[str]:
        """The running plugins that do not override `get_state`, as `model/plugin`."""
        return plugin_state.without_hooks(self.contents.plugins)


class WorldPlugin(Plugin):
    """A plugin of the world.

    `flatland_server.plugins.plugin` describes the life of a plugin.

    Attributes:
        type: its type, as in its configuration.
        name: unique among the plugins of the world.
        node: its access to topics, transforms and parameters.
        rng: its random numbers, which depend only on the seed of the world and on its name.
        world: its world, with layers and models.
    """

    def __init__(
        self, type: str, name: str, node: Node, rng: np.random.Generator, world: World
    ) -> None:
        super().__init__(type, name, node, rng)
        self.world = world


def _pose_of(value: PoseLike) -> Pose:
    try:
        x, y, yaw = value
        pose = Pose(float(x), float(y), float(yaw))
    except (TypeError, ValueError, OverflowError):
        found = shortened(repr(value))
        raise UsageError(f"expected a pose [x, y, yaw], found {found}") from None
    if not pose.is_finite():
        raise ModelError(f"expected a finite pose, found x={pose.x} y={pose.y} theta={pose.yaw}")
    return pose

"""The world: layers, models and plugins, read from a file and moved step by step.

world = World.from_file(Path("world.yaml"))
timekeeper = Timekeeper(step_size=0.005)
world.step(timekeeper)
"""

import logging
from contextlib import closing, suppress
from pathlib import Path
from typing import Callable, Dict, List, Optional, Set

from flatland_server import _core
from flatland_server.arrays import Segments
from flatland_server.config.ros_names import namespace_problem, topic_name_problem
from flatland_server.config.yaml_preprocessor import YamlPreprocessor, is_file
from flatland_server.exceptions import (
    FlatlandError,
    LayerError,
    ModelError,
    PluginError,
    Problem,
    YamlError,
    suggestion,
)
from flatland_server.geometry import Pose
from flatland_server.models.entity import Entities
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model, ModelConfig
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.plugins.plugin_manager import PluginFailure, PluginManager
from flatland_server.plugins.world_plugin import WorldPlugin
from flatland_server.simulation.world_config import ModelEntry, WorldConfig
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.node import Node, Transport

logger = logging.getLogger(__name__)

_MOST_DEFERRED = 1000
"""How many things that plugins ask for within hooks are done in a row."""


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
        self.entities = Entities()
        self._loader = loader or PluginLoader()
        self._plugins = PluginManager(
            Node(self.transport), self._loader, seed, self.physics, self.entities
        )
        self._is_locked = False  # while it steps, takes bodies away (contacts are told of) or ends
        self._unsettled: Set[str] = set()  # models that are being started or stopped
        self._deferred: List[Callable[[], None]] = []
        try:
            self.layers = [Layer(layer, self.physics, self.entities) for layer in config.layers]
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

    @property
    def plugin_failures(self) -> List[PluginFailure]:
        """The plugins that have failed and are switched off."""
        return self._plugins.failures

    def spawn_model(self, path: Path, name: str, namespace: str, pose: Pose) -> Optional[Model]:
        """Puts a new model into the world: wholly, or not at all.

        Within a step, that is in a plugin's hook, the model comes at the end of the step, and None
        is returned; should it not start, that is logged.

        Args:
            path: of the model file.
            name: unique in the world.
            namespace: of its topics and frames; may be empty.
            pose: where its origin is put.

        Raises:
            FlatlandError: the file, the name, the namespace or the pose is not usable; the world is
                then as it was.
        """
        entry = self.read_model_entry(path, name, namespace, pose)
        if not self._is_locked:
            return self.add_model(entry)
        self._deferred.append(lambda: self._add_later(entry))
        return None

    def read_model(self, path: Path) -> ModelConfig:
        """What a model file says, for this world; may be called by any thread.

        Raises:
            FlatlandError: there is no such file, or something in it is wrong.
        """
        if not is_file(path):
            raise ModelError(f"there is no file {path}")
        with closing(YamlPreprocessor(self.transport.get_param)) as preprocessor:
            return ModelConfig.from_file(path, self.registry, preprocessor)

    def read_model_entry(self, path: Path, name: str, namespace: str, pose: Pose) -> ModelEntry:
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
        self._require_new(name)
        _check_pose(pose)
        model = self.read_model(path)
        for plugin in model.plugins:
            with suppress(PluginError):  # add_model reports it, with its line
                self._loader.load(plugin.type, ModelPlugin)
        return ModelEntry(name, namespace, pose, model)

    def add_model(self, entry: ModelEntry) -> Model:
        """Puts a model into the world that has been read, or made without a file.

        Raises:
            FlatlandError: its name is taken, it does not fit in, or one of its plugins does not
                start; the world is then as it was. Or the world is in the midst of a step.
        """
        if self._is_locked:
            raise FlatlandError(
                "add_model is for between steps; spawn_model may be called in a hook"
            )
        self._require_new(entry.name)
        there_before = set(self.models.values())
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
        self._unsettled.add(entry.name)
        plugins = entry.model.plugins
        try:
            self._plugins.start(plugins, ModelPlugin, entry.name, entry.namespace, model)
        except BaseException:
            del self.models[entry.name]
            self._take_away(model)
            for other in [each for each in self.models.values() if each not in there_before]:
                self._remove(other)  # its plugins had spawned it
            raise
        finally:
            self._unsettled.discard(entry.name)
        self._run_deferred()
        return model

    def delete_model(self, name: str) -> None:
        """Takes a model out of the world, with its topics and frames.

        In a plugin's hook, this happens at the end of the step.

        Raises:
            ModelError: there is no such model.
        """
        model = self.get_model(name)
        if self._is_locked or name in self._unsettled:
            self._deferred.append(lambda: self._remove(model))
        else:
            self._remove(model)
            self._run_deferred()

    def move_model(self, name: str, pose: Pose) -> None:
        """Puts a model somewhere else, at rest.

        In a plugin's hook, this happens at the end of the step.

        Raises:
            ModelError: there is no such model, or the pose is not usable.
        """
        model = self.get_model(name)
        _check_pose(pose)
        if self._is_locked:
            self._deferred.append(lambda: self._move_later(model, pose))
        else:
            model.move(pose)

    def add_walls(self, layer: str, segments: Segments) -> None:
        """Puts up walls in a layer.

        Args:
            layer: one of its names.
            segments: in the world [m]: shape (n, 4), x1, y1, x2, y2.

        Raises:
            FlatlandError: there is no such layer, or the world is in the midst of a step.
            ValueError: a segment is not finite, or of no length.
        """
        if self._is_locked:
            raise FlatlandError("walls are put up between steps, not during one")
        found = self.get_layer(layer)
        found.add_walls(segments)
        self._plugins.refresh(found)

    def get_layer(self, name: str) -> Layer:
        """The layer that has this name among its names.

        Raises:
            LayerError: there is none.
        """
        for layer in self.layers:
            if name in layer.config.names:
                return layer
        known = ", ".join(self.registry.names) or "none"
        hint = suggestion(name, self.registry.names)
        raise LayerError(f'no layer is named "{name}"{hint}; there are: {known}')

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
        self._is_locked = True
        try:
            self._plugins.before_physics_step(timekeeper)
            self.physics.step(timekeeper.step_size)
            timekeeper.step()
            self._plugins.after_physics_step(timekeeper)
        finally:
            self._is_locked = False
        if self._deferred:
            self._run_deferred()
        self.transport.flush()

    def close(self) -> None:
        """Ends all plugins; what they still ask for is not done any more."""
        self._is_locked = True
        try:
            self._plugins.stop_all()
        finally:
            self._is_locked = False
            self._deferred.clear()

    def _require_new(self, name: str) -> None:
        if name in self.models:
            raise ModelError(f'a model named "{name}" is already there')

    def _remove(self, model: Model) -> None:
        if self.models.get(model.name) is not model:
            return  # somebody else was quicker
        self._unsettled.add(model.name)
        try:
            self._plugins.stop(model.name)
        finally:
            self._unsettled.discard(model.name)
            del self.models[model.name]
            self._take_away(model)

    def _take_away(self, model: Model) -> None:
        """Removes its bodies; plugins hear of the contacts that this ends."""
        self._is_locked = True
        try:
            model.remove()
        finally:
            self._is_locked = False

    def _add_later(self, entry: ModelEntry) -> None:
        try:
            self.add_model(entry)
        except FlatlandError as error:
            logger.error('the model "%s" is not spawned: %s', entry.name, error)

    def _move_later(self, model: Model, pose: Pose) -> None:
        if self.models.get(model.name) is not model:
            return
        try:
            model.move(pose)
        except FlatlandError as error:
            logger.error("%s", error)

    def _run_deferred(self) -> None:
        """Does what plugins have asked for, and what they ask for meanwhile.

        Not while others are still being started or stopped, who may be whom this is about. Should
        it never end, the rest has to wait for the next step.
        """
        for _ in range(_MOST_DEFERRED):
            if not self._deferred or self._is_locked or self._unsettled:
                return
            self._deferred.pop(0)()


def _check_pose(pose: Pose) -> None:
    if not pose.is_finite():
        raise ModelError(f"expected a finite pose, found x={pose.x} y={pose.y} theta={pose.yaw}")

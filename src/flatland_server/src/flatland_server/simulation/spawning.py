"""Spawning, deleting and moving models in a running world."""

import logging
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Sequence, Union

from flatland_server import _core
from flatland_server.arrays import PoseLike
from flatland_server.config.file_names import find_file, is_bare, nor_in
from flatland_server.config.input_files import is_file
from flatland_server.config.ros_names import namespace_problem, topic_name_problem
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import (
    FlatlandError,
    ModelError,
    PluginError,
    UsageError,
    listed,
    shortened,
    suggestion,
)
from flatland_server.geometry import Pose
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.entity import Entities
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model, ModelConfig
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.plugins.plugin_manager import PluginManager
from flatland_server.simulation.additions import Additions
from flatland_server.simulation.deferred_actions import DeferredActions
from flatland_server.simulation.world_config import ModelEntry
from flatland_server.transport.transport import Transport

logger = logging.getLogger(__name__)

ModelSource = Union[str, Path, Mapping[str, Any]]
"""A model's file, or its content."""


class Spawning:
    """The part of a `World` that adds, removes and moves models.

    A model is read from its file in any thread (`read_model_entry`), and added between two steps
    (`add_model`); `spawn_model` does both.
    """

    transport: Transport
    physics: _core.World
    registry: CollisionFilterRegistry
    entities: Entities
    models: Dict[str, Model]
    _model_folders: Sequence[Path]
    _loader: PluginLoader
    _plugins: PluginManager
    _deferred: DeferredActions
    _additions: Additions
    _is_starting: bool

    def get_model(self, name: str) -> Model:
        """The model of this name.

        Args:
            name: of the model.

        Raises:
            ModelError: there is no such model.
        """
        if name not in self.models:
            hint = suggestion(name, self.models)
            raise ModelError(f'there is no model "{shortened(name)}"{hint}')
        return self.models[name]

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
        return self._deferred.run_or_defer(
            lambda: self._spawn(entry), f'the model "{name}" is not spawned'
        )

    def overlap_warning(self, model: Model) -> str:
        """A warning about a model that was put within walls or other models.

        Args:
            model: of this world.

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

        Args:
            path: of the file, or the content of one as a dict.

        Raises:
            FlatlandError: there is no such file, or something in it is wrong.
        """
        if not isinstance(path, (str, Path)):
            with closing(YamlPreprocessor(self.transport.get_param)) as preprocessor:
                return ModelConfig.from_content(path, self.registry, preprocessor)
        if not str(path):
            raise ModelError("expected the path of a model file, found an empty string")
        folders = self._model_folders if is_bare(path) else ()
        try:
            found = find_file(path, [Path(), *folders])
        except FlatlandError as error:
            raise ModelError(str(error)) from None
        if not is_file(found):
            raise ModelError(f"there is no file {found.absolute()}{nor_in(folders)}")
        with closing(YamlPreprocessor(self.transport.get_param)) as preprocessor:
            return ModelConfig.from_file(found, self.registry, preprocessor)

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
        self._check_name_is_free(name)
        place = _pose_of(pose)
        model = self.read_model(path)
        for plugin in model.plugins:
            with suppress(PluginError):  # add_model reports it, with its line
                self._loader.load(plugin.type, ModelPlugin)
        return ModelEntry(name, namespace, place, model)

    def add_model(self, entry: ModelEntry) -> Model:
        """Adds a model that has been read already, or made without a file, to the world.

        Args:
            entry: of `read_model_entry`, or made by a program.

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

        Args:
            name: of the model.

        Raises:
            ModelError: there is no such model.
        """
        model = self.get_model(name)
        self._deferred.run_or_defer(
            lambda: self._remove(model),
            f'the model "{name}" is not deleted',
            unless_changing=name,
        )

    def move_model(self, name: str, pose: PoseLike) -> None:
        """Puts a model at another pose, at rest.

        In a plugin's hook, this happens at the end of the step; a failure is then logged.

        Args:
            name: of the model.
            pose: x, y [m] and yaw [rad] of its origin in the world.

        Raises:
            FlatlandError: there is no such model, or the pose is not usable.
        """
        model = self.get_model(name)
        place = _pose_of(pose)
        self._deferred.run_or_defer(
            lambda: self._move(model, place), f'the model "{name}" is not moved'
        )

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


def _pose_of(value: PoseLike) -> Pose:
    try:
        x, y, yaw = value
        pose = Pose(float(x), float(y), float(yaw))
    except (TypeError, ValueError):
        found = shortened(repr(value))
        raise UsageError(f"expected a pose [x, y, yaw], found {found}") from None
    if not pose.is_finite():
        raise ModelError(f"expected a finite pose, found x={pose.x} y={pose.y} theta={pose.yaw}")
    return pose

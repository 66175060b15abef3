"""The contents of a world; a reset makes new ones."""

from typing import Dict, List, Mapping, Optional

import numpy as np

from flatland_server import _core
from flatland_server.arrays import Segments
from flatland_server.exceptions import ModelError, Problem, StateError, YamlError
from flatland_server.geometry import Pose
from flatland_server.models.entity import Entities
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.plugins.plugin_manager import PluginManager, PluginRevision
from flatland_server.simulation.deferred_actions import DeferredActions
from flatland_server.simulation.load_progress import LoadProgress
from flatland_server.simulation.world_config import ModelEntry, WorldConfig
from flatland_server.simulation.world_state import ModelState, WallsState
from flatland_server.transport.transport import Transport


class AddedObjects:
    """Models and walls added to a world since it was made, in their order; for saved states.

    Rebuilding the world or a plugin brings back those that come with the world or that plugins add
    in `on_initialize`. Such walls are not recorded, such models only because they may be deleted.

    Attributes:
        entries: by name, those of all models of the world, with the poses at which they were added.
        walls: the added walls.
    """

    def __init__(self) -> None:
        self._count = 0
        self.entries: Dict[str, ModelEntry] = {}
        self._orders: Dict[str, Optional[int]] = {}
        self.walls: List[WallsState] = []

    def add_model(self, entry: ModelEntry, comes_with_another: bool) -> None:
        """Records a model.

        Args:
            entry: the model's entry.
            comes_with_another: whether a rebuild of the world or of another model adds it again.
        """
        self._count += 1
        self.entries[entry.name] = entry
        self._orders[entry.name] = None if comes_with_another else self._count

    def remove_model(self, name: str) -> None:
        """Removes the record of a model."""
        self.entries.pop(name, None)
        self._orders.pop(name, None)

    def add_walls(self, layer: int, segments: Segments) -> None:
        """Records walls of a layer that no rebuild of the world or of a model adds again."""
        self._count += 1
        self.walls.append(WallsState(self._count, layer, np.array(segments)))

    def states_of(self, models: Mapping[str, Model]) -> List[ModelState]:
        """The states of the models that exist, in the order in which they were added.

        Args:
            models: models of the world, by name.

        Raises:
            StateError: one of them has no file that it could be read from again.
        """
        states = []
        for name, entry in self.entries.items():
            order = self._orders[name]
            if order is not None and not entry.model.is_read:
                raise StateError(f'the model "{name}" was made by a program, without a file')
            path = str(entry.model.path.absolute())
            content = entry.model.content
            states.append(
                ModelState(
                    name,
                    order,
                    entry.namespace,
                    path,
                    list(entry.pose),
                    models[name].move_revision,
                    dict(content) if isinstance(content, Mapping) else content,
                )
            )
        return states


class WorldContents:
    """The layers, models and plugins of a world, and the physics that moves them.

    Args:
        config: the contents of the world's files.
        seed: seed of all random numbers.
        transport: carries the topics of the plugins.
        loader: finds plugin classes.
        revision: counter of the changes of plugins.
        former: the contents that these replace, if any.

    Attributes:
        physics: the Box2D world, in the core.
        entities: the model or layer that each body belongs to.
        models: by name.
        plugins: of the world and its models.
        plan: the time until which steps call no hooks.
        deferred: changes that wait until they are safe.
        added: models and walls that have been added since the world was made.
        layout: the poses of models as a world file has them: those of the file, as clients have
            spawned, moved and deleted them. Robots that drive and what plugins do change nothing.
        is_changing: whether all of its plugins are being started or stopped.
    """

    def __init__(
        self,
        config: WorldConfig,
        seed: int,
        transport: Transport,
        loader: PluginLoader,
        revision: PluginRevision,
        former: Optional["WorldContents"] = None,
    ) -> None:
        self.config = config = config.for_seed(seed)
        self.seed = seed
        self.physics = _core.World(config.velocity_iterations, config.position_iterations)
        self._tf_by_namespace = transport.tf_by_namespace
        self.entities = Entities()
        self.models: Dict[str, Model] = {}
        self.layers: List[Layer] = []
        self.plugins = PluginManager(transport, loader, seed, self.physics, self.entities, revision)
        if former is not None:
            self.plugins.on_failure = former.plugins.on_failure
        self.plan = self.plugins.plan
        self.deferred = DeferredActions()
        self.added = AddedObjects()
        self.layout: Dict[str, Pose] = {entry.name: entry.pose for entry in config.models}
        self.is_changing = True

    def add_layers_and_models(self) -> None:
        """Adds the layers and models of the files.

        Raises:
            FlatlandError: a model cannot be created, or a plugin of one does not start.
        """
        self._add_layers()
        problems: List[Problem] = []
        for entry in self.config.models:
            try:
                self.add_model(entry)
            except YamlError as error:
                problems.extend(error.problems)
        if problems:
            raise YamlError.of(problems)

    def _add_layers(self) -> None:
        walls = [self.config.walls_of(layer) for layer in self.config.layers]
        progress = LoadProgress(sum(map(len, walls)))
        for layer, segments in zip(self.config.layers, walls):
            self.layers.append(Layer(layer, segments, self.physics, self.entities, progress.update))
            progress.layer_is_complete(len(segments))

    def check_name_is_free(self, name: str) -> None:
        """Raises a ModelError if there is a model of this name."""
        if name in self.models:
            raise ModelError(f'a model named "{name}" is already there')

    def add_model(self, entry: ModelEntry) -> Model:
        """Adds a model: completely, or not at all.

        Raises:
            FlatlandError: its name is taken, its bodies cannot be created, or one of its plugins
                does not start.
        """
        name = entry.name
        self.check_name_is_free(name)
        model = Model(
            name,
            entry.namespace,
            entry.model,
            entry.pose,
            self.physics,
            self.config.registry,
            self.entities,
            self.deferred.change_shapes,
            self._tf_by_namespace,
        )
        self.models[name] = model
        with self.deferred.changing(name):
            try:
                self.plugins.start(entry.model.plugins, ModelPlugin, name, model.namespace, model)
            except BaseException:
                in_order = list(self.models.values())
                del self.models[name]
                self._remove_bodies(model)
                for other in in_order[in_order.index(model) + 1 :]:
                    self.remove_model(other)  # spawned by the failed model's plugins
                raise
        self.added.add_model(entry, self._comes_with_another)
        self.deferred.run_pending()
        return model

    def remove_model(self, model: Model) -> None:
        """Removes a model with its plugins, if it is still there."""
        if not self.has(model):
            return
        with self.deferred.changing(model.name):
            try:
                self.plugins.stop(model.name)
            finally:
                del self.models[model.name]
                self.added.remove_model(model.name)
                self._remove_bodies(model)

    def has(self, model: Model) -> bool:
        """True if a model is still there; it may be deleted before a deferred action runs."""
        return self.models.get(model.name) is model

    def add_walls(self, layer: Layer, segments: Segments) -> None:
        """Adds walls to one of the layers.

        Raises:
            ValueError: a segment is not finite, or has no length.
        """
        layer.add_walls(segments)
        if not self._comes_with_another:
            self.added.add_walls(self.layers.index(layer), segments)
        self.plugins.contacts.refresh(layer)

    @property
    def _comes_with_another(self) -> bool:
        """True if a rebuild of the world or of a model repeats what is added now."""
        return self.is_changing or self.plugins.is_starting

    def close(self) -> None:
        """Stops all plugins. Changes that they request meanwhile are dropped."""
        self.is_changing = True
        try:
            with self.deferred.lock:
                self.plugins.stop_all()
        finally:
            self.deferred.pending.clear()
            self.is_changing = False

    def discard(self) -> None:
        """Stops all plugins and removes all bodies: handles to them raise from now on."""
        self.close()
        for model in self.models.values():
            self._remove_bodies(model)
        self.entities.clear()

    def _remove_bodies(self, model: Model) -> None:
        with self.deferred.lock:  # it ends contacts, which calls hooks
            model.remove()

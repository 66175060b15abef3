"""Rebuilding the contents of a world: resets, other files, and saved states."""

from abc import ABC, abstractmethod
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Callable, Dict, List, Optional, cast

from flatland_server import _core
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import FlatlandError, StateError
from flatland_server.models.entity import Entities
from flatland_server.models.model import Model
from flatland_server.plugins.plugin_manager import PluginManager
from flatland_server.simulation import plugin_state
from flatland_server.simulation.additions import Additions, check_walls, replay, wall_counts
from flatland_server.simulation.deferred_actions import DeferredActions
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.simulation.world_state import WorldState
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.transport import Transport

if TYPE_CHECKING:
    from flatland_server.simulation.world import World


class Restartable(ABC):
    """The part of a `World` that replaces its contents as a whole, between two steps.

    The new contents are made while the old ones still exist. If this fails, the old ones are kept;
    otherwise their plugins are shut down afterwards. So topics that both have keep their
    connections.
    """

    transport: Transport
    physics: _core.World
    entities: Entities
    models: Dict[str, Model]
    _config: WorldConfig
    _seed: int
    _plugins: PluginManager
    _deferred: DeferredActions
    _additions: Additions
    _is_starting: bool

    @abstractmethod
    def _start(self, config: WorldConfig, seed: int) -> None:
        """Makes all that the world consists of, in place of what there was."""

    @abstractmethod
    def _remove_bodies(self, model: Model) -> None:
        """Removes the bodies of a model."""

    @abstractmethod
    def close(self) -> None:
        """Stops all plugins."""

    def reset(self, seed: Optional[int] = None) -> None:
        """Rebuilds the world as it was loaded: its models, plugins, walls and random numbers.

        What follows equals, bit for bit, a run of a newly loaded world. No file is read. Models and
        plugins are new objects, and the former ones are gone; topics stay connected.

        In a plugin's hook, this happens at the end of the step; a failure is then logged. What is
        requested in the same step after it fails, too.

        Args:
            seed: of all random numbers from now on; None is the same as before.

        Raises:
            FlatlandError: a plugin does not start again, or this is called in `on_initialize` or
                `on_shutdown`. The world is unchanged.
        """
        if self._is_starting or not (self._deferred.is_free or self._deferred.is_locked):
            raise FlatlandError("the world cannot be reset while plugins are started or stopped")
        config, chosen = self._config, self._seed if seed is None else seed
        self._deferred.run_or_defer(
            lambda: self._replace(lambda: self._start(config, chosen)), "the world is not reset"
        )

    def read_config(self, path: Optional[Path] = None) -> WorldConfig:
        """Reads a world's files, for `reload`; may be called in any thread.

        Args:
            path: of the world file; None reads this world's own again.

        Raises:
            FlatlandError: something in them is wrong, or the world was made without a file.
        """
        path = path or self._config.path
        if path is None:
            raise FlatlandError("the world was made without a file")
        with closing(YamlPreprocessor(self.transport.get_param)) as preprocessor:
            return WorldConfig.from_file(
                path,
                preprocessor,
                simplify_map=self._config.simplify_map,
                model_folders=self._config.model_folders[1:],  # the first is the world's own
            )

    def reload(self, config: WorldConfig) -> None:
        """Replaces all contents by those of another configuration; otherwise like `reset`.

        Args:
            config: of the new contents.

        Raises:
            FlatlandError: a model or plugin does not start, or a step is being made. The world is
                unchanged.
        """
        self.require_between_steps("reload")
        self._replace(lambda: self._start(config, self._seed))

    def save_state(self, timekeeper: Timekeeper) -> bytes:
        """The state of the world, for `load_state`: in this world, or in another process.

        From here on, this world goes on, bit for bit, like each one that loads the state. See
        docs/plugins/programs_and_states.md about what is saved of plugins.

        Args:
            timekeeper: has the time.

        Raises:
            StateError: a plugin's state cannot be saved, or a model has no file that it could be
                read from again; or a step is being made.
        """
        self.require_between_steps("save_state")
        self._plugins.pass_over(timekeeper.nanoseconds - timekeeper.step_nanoseconds)
        return WorldState(
            str(self._config.path or ""),
            self._seed,
            timekeeper.nanoseconds,
            wall_counts(self._config),
            self._additions.states_of(self.models),
            self._additions.walls,
            plugin_state.collect(self._plugins),
            self.physics.save_state(),
        ).dumps()

    def load_state(self, state: bytes, timekeeper: Timekeeper) -> None:
        """Puts the world into a state that was saved in a world of equal files.

        Models and plugins are new objects, and the former ones are gone; topics stay connected.
        Files of models that were spawned are read again.

        Args:
            state: of `save_state`.
            timekeeper: is set to the time of the state.

        Raises:
            FlatlandError: the state is damaged or does not fit, a file is missing, or a step is
                being made. The world is unchanged.
        """
        self.require_between_steps("load_state")
        loaded = WorldState.loads(state)
        self._replace(lambda: self._restore(loaded))
        timekeeper.jump_to(loaded.nanoseconds)

    @property
    def plugins_without_state_hooks(self) -> List[str]:
        """The running plugins of which a saved state has no attributes, as `model/plugin`."""
        return plugin_state.without_hooks(self._plugins)

    def _restore(self, state: WorldState) -> None:
        """Rebuilds the world, repeats what was added and deleted, and sets the state."""
        self._start(self._config, state.seed)
        check_walls(state, self._config)
        replay(state, cast("World", self))
        plugin_state.restore_failures(self._plugins, state.plugins)
        try:
            self.physics.restore_state(state.physics)
        except ValueError as error:
            raise StateError(str(error)) from None
        plugin_state.restore(self._plugins, state.plugins)

    def _replace(self, make: Callable[[], None]) -> None:
        """Rebuilds all contents of the world; if this fails, the old contents are kept.

        The new plugins start while the former ones are there, so that topics stay connected.
        """
        former = dict(vars(self))
        try:
            make()
        except BaseException:
            self._discard()
            vars(self).update(former)
            raise
        new = dict(vars(self))
        vars(self).update(former)
        self._deferred.drop("the world has been reset before")
        self._discard()
        vars(self).update(new)
        self.transport.discard()

    def _discard(self) -> None:
        """Closes the world and removes its bodies, so that no handle goes on working unnoticed."""
        self.close()
        for model in self.models.values():
            self._remove_bodies(model)
        self.entities.clear()

    def require_between_steps(self, name: str) -> None:
        """Checks that no step is being made, and no plugin is being started or stopped.

        Args:
            name: of the function that is called, for the error.

        Raises:
            FlatlandError: otherwise.
        """
        if self._is_starting or not self._deferred.is_free:
            raise FlatlandError(f"{name} is for between steps, not for hooks")

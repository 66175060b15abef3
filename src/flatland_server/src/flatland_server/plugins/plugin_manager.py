"""The living plugins: starts them, calls their hooks, ends them; and those that failed."""

import logging
import sys
import zlib
from typing import Any, Callable, Dict, List, NamedTuple, Sequence, Type, TypeVar

import numpy as np

from flatland_server import _core
from flatland_server.exceptions import FlatlandError, PluginError, Problem, YamlError
from flatland_server.models.entity import Entities, Entity
from flatland_server.models.plugin_config import PluginConfig
from flatland_server.plugins.contact_dispatcher import ContactDispatcher
from flatland_server.plugins.plugin import HOOKS, STEP_HOOKS, Plugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.plugins.schedule import Due, Entry, Schedule
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.node import Node

logger = logging.getLogger(__name__)

P = TypeVar("P", bound=Plugin)
Hook = Callable[..., None]


class PluginFailure(NamedTuple):
    """Why a plugin was switched off."""

    owner: str
    """Its model's name; empty if it belongs to the world."""
    name: str
    type: str
    reason: str
    """The hook, and what it raised."""

    @property
    def label(self) -> str:
        """`model/plugin`, or the name alone of a plugin of the world."""
        return f"{self.owner}/{self.name}" if self.owner else self.name


class PluginManager:
    """Starts, calls and ends plugins.

    Args:
        node: the world's node; each plugin gets one of its own within.
        loader: finds plugin classes.
        seed: the world's seed.
        physics: the world, whose contacts plugins hear of.
        entities: who has a part in them.
    """

    def __init__(
        self,
        node: Node,
        loader: PluginLoader,
        seed: int,
        physics: _core.World,
        entities: Entities,
    ) -> None:
        self._node = node
        self._loader = loader
        self._seed = seed
        self._contacts = ContactDispatcher(physics, entities, self._call)
        self._failures: Dict[Plugin, PluginFailure] = {}
        self._plugins: Dict[str, List[Plugin]] = {}
        self._schedule = Schedule(self._has_work)
        self._due = Due([])

    def plugins_of(self, owner: str) -> List[Plugin]:
        """The living plugins of a model, or of the world, whose name is empty."""
        return list(self._plugins.get(owner, []))

    @property
    def failures(self) -> List[PluginFailure]:
        """The plugins that were switched off, of the models that still exist."""
        return list(self._failures.values())

    def refresh(self, entity: Entity) -> None:
        """An entity has got new bodies."""
        self._contacts.refresh(entity)

    def start(
        self,
        configs: Sequence[PluginConfig],
        base: Type[P],
        owner: str,
        namespace: str,
        subject: Any,
    ) -> None:
        """Starts the plugins of a model or the world: all of them, or none.

        Args:
            configs: their entries.
            base: what they must be derived from.
            owner: the model's name, or the empty string.
            namespace: of their topics.
            subject: the model, or the world.

        Raises:
            FlatlandError: one does not exist, or does not start.
        """
        self._plugins[owner] = []
        problems: List[Problem] = []
        try:
            for config in configs:
                try:
                    self._start_one(config, base, owner, namespace, subject)
                except YamlError as error:
                    problems.extend(error.problems)
            if problems:
                raise YamlError.of(problems)
        except BaseException:
            self.stop(owner)
            raise
        entity = subject if isinstance(subject, Entity) else None
        for plugin in self._plugins[owner]:
            hooks = _overridden(plugin)
            around = {name: hooks[name] for name in STEP_HOOKS if name in hooks}
            if around:
                self._schedule.add(Entry(plugin, around))
            self._contacts.add(plugin, entity, hooks)
        if entity is not None:
            self._contacts.refresh(entity)

    def _start_one(
        self, config: PluginConfig, base: Type[P], owner: str, namespace: str, subject: Any
    ) -> None:
        reader = config.reader
        try:
            plugin_class = self._loader.load(config.type, base)
        except PluginError as error:
            raise reader.error(str(error), "type") from error.__cause__
        label = f"{owner}/{config.name}" if owner else config.name
        rng = np.random.default_rng([self._seed, zlib.crc32(label.encode())])
        node = self._node.scoped(namespace, label)
        try:
            plugin = plugin_class(config.type, config.name, node, rng, subject)  # type: ignore[call-arg]
            node.on_failure = lambda where: self._fail(plugin, where)
            plugin.on_initialize(reader)
            reader.finish()
        except BaseException as error:
            node.close()
            if isinstance(error, YamlError) or not isinstance(error, Exception):
                raise
            reason = str(error)
            if not isinstance(error, FlatlandError):
                reason = f"does not start: {type(error).__name__}: {error}"
            raise reader.error(reason) from error
        self._plugins[owner].append(plugin)

    def stop(self, owner: str) -> None:
        """Ends the plugins of a model or the world, the last one first."""
        plugins = self._plugins.pop(owner, [])
        self._call_no_more(plugins)
        for plugin in reversed(plugins):
            if self._failures.pop(plugin, None) is None:
                self._end(plugin)

    def _end(self, plugin: Plugin) -> None:
        try:
            plugin.on_shutdown()
        except Exception:
            logger.exception('the plugin "%s" failed in on_shutdown', plugin.node.owner)
        plugin.node.close()

    def stop_all(self) -> None:
        """Ends all plugins."""
        for owner in list(self._plugins):
            self.stop(owner)

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Calls the hook of every plugin that is due."""
        self._due = self._schedule.due(timekeeper, self._node.subscriber_revision)
        self._call_due("prepare_step", timekeeper)
        self._call_due("before_physics_step", timekeeper)

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Calls the hook of every plugin that was due before the step."""
        self._call_due("after_physics_step", timekeeper)

    def _call_due(self, name: str, timekeeper: Timekeeper) -> None:
        for entry, hook in self._due.calls[name]:
            if not entry.is_gone:
                self._call(entry.plugin, name, hook, timekeeper)

    def _has_work(self, plugin: Plugin) -> bool:
        try:
            return plugin.has_work()
        except Exception:
            self._fail(plugin, "has_work")
            return False

    def _call(self, plugin: Plugin, name: str, hook: Hook, *arguments: Any) -> None:
        try:
            hook(*arguments)
        except Exception:
            self._fail(plugin, name)

    def _fail(self, plugin: Plugin, where: str) -> None:
        """Switches a plugin off, in the face of the exception that it raised somewhere."""
        if plugin in self._failures:
            return
        owner = next((name for name, each in self._plugins.items() if plugin in each), None)
        if owner is None:  # it has deleted its own model, and so has ended already
            logger.exception('the plugin "%s" failed in %s', plugin.node.owner, where)
            return
        error = sys.exc_info()[1]
        reason = f"{where}: {type(error).__name__}: {error}"
        failure = PluginFailure(owner, plugin.name, plugin.type, reason)
        logger.exception('the plugin "%s" failed in %s and is switched off', failure.label, where)
        self._failures[plugin] = failure
        self._call_no_more([plugin])
        self._end(plugin)

    def _call_no_more(self, plugins: Sequence[Plugin]) -> None:
        """Calls no more hooks of these plugins."""
        self._schedule.remove(plugins)
        self._contacts.remove(plugins)


def _overridden(plugin: Plugin) -> Dict[str, Hook]:
    """Those of a plugin's hooks that are not the base class's empty ones, by name."""
    return {
        name: getattr(plugin, name)
        for name in HOOKS
        if getattr(type(plugin), name) is not getattr(Plugin, name)
    }

"""The living plugins: starts them, calls their hooks, ends them."""

import logging
import zlib
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Type, TypeVar

import numpy as np

from flatland_server.exceptions import FlatlandError, PluginError, Problem, YamlError
from flatland_server.node import Node
from flatland_server.plugin import HOOKS, Plugin
from flatland_server.plugin_config import PluginConfig
from flatland_server.plugin_loader import PluginLoader
from flatland_server.timekeeper import Timekeeper

logger = logging.getLogger(__name__)

P = TypeVar("P", bound=Plugin)
Hook = Callable[[Timekeeper], None]


class _Entry(NamedTuple):
    """A plugin, and those of its hooks that it overrides."""

    plugin: Plugin
    before: Optional[Hook]
    after: Optional[Hook]


class PluginManager:
    """Starts, calls and ends plugins.

    Args:
        node: the world's node; each plugin gets one of its own within.
        loader: finds plugin classes.
        seed: the world's seed.
    """

    def __init__(self, node: Node, loader: PluginLoader, seed: int) -> None:
        self._node = node
        self._loader = loader
        self._seed = seed
        self._plugins: Dict[str, List[Plugin]] = {}
        self._entries: List[_Entry] = []
        self._due: List[_Entry] = []

    def plugins_of(self, owner: str) -> List[Plugin]:
        """The living plugins of a model, or of the world, whose name is empty."""
        return list(self._plugins.get(owner, []))

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
        for plugin in self._plugins[owner]:
            before, after = (_overridden(plugin, hook) for hook in HOOKS)
            if before is not None or after is not None:
                self._entries.append(_Entry(plugin, before, after))

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
        for plugin in reversed(plugins):
            try:
                plugin.on_shutdown()
            except Exception:
                logger.exception('the plugin "%s" failed in on_shutdown', plugin.name)
            plugin.node.close()
        self._switch_off(plugins)

    def stop_all(self) -> None:
        """Ends all plugins."""
        for owner in list(self._plugins):
            self.stop(owner)

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Calls the hook of every plugin that is due."""
        self._due = [
            entry
            for entry in self._entries
            if (timer := entry.plugin.update_timer) is None or timer.check_update(timekeeper)
        ]
        for entry in self._due:
            if entry.before is not None:
                self._call(entry, entry.before, timekeeper)

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Calls the hook of every plugin that was due before the step."""
        for entry in self._due:
            if entry.after is not None:
                self._call(entry, entry.after, timekeeper)

    def _call(self, entry: _Entry, hook: Hook, timekeeper: Timekeeper) -> None:
        try:
            hook(timekeeper)
        except Exception:
            logger.exception(
                'the plugin "%s" failed in %s and is switched off',
                entry.plugin.name,
                hook.__name__,
            )
            self._switch_off([entry.plugin])

    def _switch_off(self, plugins: Sequence[Plugin]) -> None:
        """Calls no more hooks of these plugins."""
        gone = {id(plugin) for plugin in plugins}
        self._entries = [entry for entry in self._entries if id(entry.plugin) not in gone]
        self._due = [entry for entry in self._due if id(entry.plugin) not in gone]


def _overridden(plugin: Plugin, hook: str) -> Optional[Hook]:
    """A plugin's hook, or None if it is the base class's empty one."""
    if getattr(type(plugin), hook) is getattr(Plugin, hook):
        return None
    method: Hook = getattr(plugin, hook)
    return method

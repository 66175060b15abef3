"""Starts plugins, calls their hooks, switches off those that fail, and stops them."""

import logging
import sys
from functools import lru_cache
from typing import (
    Any,
    Callable,
    Dict,
    List,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
    Type,
    TypeVar,
)

from flatland_server import _core
from flatland_server._core import StepMessages
from flatland_server.canvas import Canvas
from flatland_server.exceptions import PLUGIN_ERRORS, Problem, YamlError
from flatland_server.models.entity import Entities, Entity
from flatland_server.models.plugin_config import PluginConfig
from flatland_server.plugins.contact_dispatcher import ContactDispatcher
from flatland_server.plugins.plugin import HOOKS, STEP_HOOKS, Plugin, plugin_label
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.plugins.plugin_rng import plugin_rng
from flatland_server.plugins.schedule import NO_CALLS, Schedule, Work
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.claims import FrameRegistry, TopicRegistry
from flatland_server.transport.node import Node
from flatland_server.transport.transport import Transport

logger = logging.getLogger(__name__)

P = TypeVar("P", bound=Plugin)
Hook = Callable[..., None]

_LAST = 2**63 - 1
"""Comes after all plugins in their order."""


class PluginRevision:
    """Counts how often the running plugins of a world have changed, for caches that compare it."""

    __slots__ = ("value",)

    def __init__(self) -> None:
        self.value = 0

    def change(self) -> None:
        """Counts that a plugin was started, stopped or switched off, or all were replaced."""
        self.value += 1


class PluginFailure(NamedTuple):
    """A plugin that was switched off, and the reason."""

    owner: str
    """The name of its model; empty for a plugin of the world."""
    name: str
    type: str
    reason: str
    """The hook or callback, and the exception that it raised."""

    @property
    def label(self) -> str:
        """`model/plugin`, or only the name for a plugin of the world."""
        return plugin_label(self.owner, self.name)


FailureHandler = Callable[[PluginFailure, BaseException], None]
"""Called with a plugin's failure and the exception that it has raised."""


class PluginManager:
    """The running plugins of a world and its models.

    Args:
        transport: carries the topics, transforms and parameters of the plugins.
        loader: finds plugin classes.
        seed: the world's seed.
        physics: physical world with the contacts.
        entities: the models and layers that take part in contacts.
        revision: counts the changes of plugins; the world's, which may get another manager.

    Attributes:
        frames: the frames that running plugins have claimed.
        topics: the topics of running plugins.
        contacts: calls the contact hooks.
        schedule: tells the step hooks that are due.
        plan: the time until which no step hook or contact hook is to be called, if known.
    """

    def __init__(
        self,
        transport: Transport,
        loader: PluginLoader,
        seed: int,
        physics: _core.World,
        entities: Entities,
        revision: PluginRevision,
    ) -> None:
        self._transport = transport
        self.frames = FrameRegistry()
        self.topics = TopicRegistry(transport)
        self._root_node = Node(transport, frames=self.frames, topics=self.topics)
        self._loader = loader
        self._seed = seed
        self._plugins: Dict[str, List[Plugin]] = {}  # by the model's name; "" is the world
        self._failures: Dict[Plugin, PluginFailure] = {}
        self.contacts = ContactDispatcher(physics, entities, self._call)
        self.schedule = Schedule(self._work_of, lambda: self.contacts.is_listening)
        self.plan = self.schedule.plan
        self._step_calls = NO_CALLS
        self.on_failure: Optional[FailureHandler] = None
        """Called when a plugin has failed and is switched off; None: failures are logged."""
        self._revision = revision
        self._starting = 0  # nesting depth of the current calls of `start`

    @property
    def is_starting(self) -> bool:
        """True while plugins are being initialized."""
        return self._starting > 0

    def all_plugins(self) -> List[Tuple[str, Plugin]]:
        """All plugins, also those that failed, each with the name of its model; "" is the world."""
        return [(owner, each) for owner, plugins in self._plugins.items() for each in plugins]

    def failure_of(self, plugin: Plugin) -> Optional[PluginFailure]:
        """The failure that has switched a plugin off; None if it runs."""
        return self._failures.get(plugin)

    def switch_off(self, plugin: Plugin, failure: PluginFailure) -> None:
        """Shuts a plugin down and does not call it any more."""
        self._failures[plugin] = failure
        self._revision.change()
        self._stop_calling([plugin])
        self._shut_down(plugin)

    def plugins_of(self, model_name: str) -> List[Plugin]:
        """The plugins of a model, or of the world if the name is empty; also those that failed."""
        return list(self._plugins.get(model_name, []))

    @property
    def failures(self) -> List[PluginFailure]:
        """The plugins that were switched off, of the models that still exist."""
        return list(self._failures.values())

    def start(
        self,
        configs: Sequence[PluginConfig],
        base: Type[P],
        model_name: str,
        namespace: str,
        subject: Any,
    ) -> None:
        """Starts the plugins of a model or of the world: all of them, or none.

        Args:
            configs: the plugins' entries in the file.
            base: base class that the plugins must have.
            model_name: name of the model; empty for the world.
            namespace: their topics' namespace.
            subject: the model, or the world, that the plugins belong to.

        Raises:
            FlatlandError: a plugin does not exist, or does not start.
        """
        plugins = self._plugins[model_name] = []
        self.plan.expire()
        problems: List[Problem] = []
        self._starting += 1
        try:
            for config in configs:
                node = self._root_node.scoped(namespace, plugin_label(model_name, config.name))
                rng = plugin_rng(self._seed, model_name, config.name)
                try:
                    plugins.append(self._loader.make(config, base, subject, node, rng, self._fail))
                    self._revision.change()
                except YamlError as error:
                    problems.extend(error.problems)
            if problems:
                raise YamlError.of(problems)
        except BaseException:
            self.stop(model_name)
            raise
        finally:
            self._starting -= 1
        entity = subject if isinstance(subject, Entity) else None
        for plugin in plugins:
            hooks = _overridden_hooks(plugin)
            step_hooks = {name: hooks[name] for name in STEP_HOOKS if name in hooks}
            if step_hooks:
                self.schedule.add(plugin, step_hooks)
            self.contacts.add(plugin, entity, hooks)
        if entity is not None:
            self.contacts.refresh(entity)

    def stop(self, model_name: str) -> None:
        """Stops the plugins of a model or of the world, in the reverse order of their start."""
        self._stop_calling(self._plugins.get(model_name, []))
        self._shut_down_all(model_name)

    def stop_all(self) -> None:
        """Stops all plugins."""
        self._stop_calling([plugin for plugins in self._plugins.values() for plugin in plugins])
        for model_name in list(self._plugins):
            self._shut_down_all(model_name)
        self._step_calls = NO_CALLS

    def steps_without_hooks(self, timekeeper: Timekeeper, limit: int) -> int:
        """The number of steps from now on, up to a limit, that need no calls of step hooks.

        It is 0 if the transport does not tell whether subscribers have changed.
        """
        revision = self._transport.subscriber_revision
        if revision != self._transport.subscriber_revision:
            return 0
        steps = self.schedule.steps_without_calls(timekeeper, revision, limit)
        if steps > 0:
            self._step_calls = NO_CALLS  # the calls of the last step would keep plugins alive
        return steps

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Calls `prepare_step` and `before_physics_step` of all plugins that are due.

        In between, the core writes the messages of the others.
        """
        self._step_calls = self.schedule.calls(timekeeper, self._transport.subscriber_revision)
        hooks = self._step_calls.hooks
        if hooks["prepare_step"]:
            self._call_step_hooks("prepare_step", timekeeper)
        messages = self.schedule.messages
        if messages is not None:
            messages.begin(timekeeper.nanoseconds)
        if hooks["before_physics_step"]:
            self._call_step_hooks("before_physics_step", timekeeper, messages)
        if messages is not None:
            messages.write_until(_LAST)

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Calls `after_physics_step` of all plugins that were due before the step."""
        if self._step_calls.plugins:
            self._call_step_hooks("after_physics_step", timekeeper)
            self.schedule.renew_plan()

    def draw(self, canvas: Canvas, timekeeper: Timekeeper) -> None:
        """Calls `draw` of all running plugins."""
        for _, plugin in self.all_plugins():
            if plugin not in self._failures:
                self._call(plugin, "draw", plugin.draw, canvas, timekeeper)

    def publish_now(self, topic: str, timekeeper: Timekeeper) -> None:
        """Calls `Plugin.publish_now` of the running plugins that publish a topic."""
        owners = self.topics.owners_of(topic)
        for _, plugin in self.all_plugins():
            if plugin.node.owner in owners and plugin not in self._failures:
                self._call(plugin, "publish_now", plugin.publish_now, timekeeper)

    def _call(self, plugin: Plugin, name: str, hook: Hook, *arguments: Any) -> None:
        """Calls a hook of a plugin, and switches the plugin off if it fails."""
        try:
            hook(*arguments)
        except PLUGIN_ERRORS:
            self._fail(plugin, name)

    def _call_step_hooks(
        self, name: str, timekeeper: Timekeeper, messages: Optional[StepMessages] = None
    ) -> None:
        for scheduled, hook in self._step_calls.hooks[name]:
            if messages is not None:
                messages.write_until(scheduled.order)
            if not scheduled.is_removed:
                try:
                    hook(timekeeper)
                except PLUGIN_ERRORS:
                    self._fail(scheduled.plugin, name)

    def _work_of(self, plugin: Plugin) -> Work:
        try:
            if not plugin.has_work():
                return False
            messages = plugin.step_messages()
            found = [each for each in messages if each is not None]
            return found if found and len(found) == len(messages) else True
        except PLUGIN_ERRORS:
            self._fail(plugin, "has_work")
            return False

    def _fail(self, plugin: Plugin, where: str) -> None:
        """Switches a plugin off; must be called while its exception is being handled."""
        if plugin in self._failures:
            return
        model_name = next((name for name, each in self._plugins.items() if plugin in each), None)
        if model_name is None:  # it has deleted its own model, and so has been shut down already
            logger.exception('the plugin "%s" failed in %s', plugin.node.owner, where)
            return
        error = sys.exc_info()[1]
        reason = f"{where}: {type(error).__name__}: {error}"
        failure = PluginFailure(model_name, plugin.name, plugin.type, reason)
        if self.on_failure is not None and error is not None:
            self.on_failure(failure, error)
        else:
            message = 'the plugin "%s" failed in %s and is switched off'
            logger.exception(message, failure.label, where)
        self.switch_off(plugin, failure)

    def _stop_calling(self, plugins: Sequence[Plugin]) -> None:
        self.schedule.remove(plugins)
        self.contacts.remove(plugins)

    def _shut_down_all(self, model_name: str) -> None:
        """Shuts down the plugins of a model or of the world, which are not called any more."""
        plugins = self._plugins.pop(model_name, [])
        self._revision.change()
        for plugin in reversed(plugins):
            if self._failures.pop(plugin, None) is None:
                self._shut_down(plugin)

    def _shut_down(self, plugin: Plugin) -> None:
        try:
            plugin.on_shutdown()
        except PLUGIN_ERRORS:
            logger.exception('the plugin "%s" failed in on_shutdown', plugin.node.owner)
        plugin.node.close()


def _overridden_hooks(plugin: Plugin) -> Dict[str, Hook]:
    """The hooks of a plugin that are not the empty ones of the base class, by name."""
    return {name: getattr(plugin, name) for name in _overridden_names(type(plugin))}  # type: ignore[arg-type]


@lru_cache(maxsize=256)
def _overridden_names(cls: Type[Plugin]) -> Tuple[str, ...]:
    return tuple(name for name in HOOKS if getattr(cls, name) is not getattr(Plugin, name))

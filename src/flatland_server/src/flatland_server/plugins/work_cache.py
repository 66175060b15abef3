"""Plugins that are due at every step, without those that have no work."""

from operator import attrgetter
from typing import AbstractSet, Callable, Set

from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.scheduled_plugin import ScheduledPlugin, StepCalls


class WorkCache:
    """Remembers which plugins have work, and asks them again only when that may have changed.

    It may change when subscribers change, since a plugin has no work if its topics have no
    subscriber, and when plugins are added or removed.

    Args:
        has_work: calls `Plugin.has_work` of a plugin. It may add and remove plugins here.
    """

    def __init__(self, has_work: Callable[[Plugin], bool]) -> None:
        self._has_work = has_work
        self._plugins: Set[ScheduledPlugin] = set()
        self._calls = StepCalls([])
        self._subscriber_revision: object = None
        self._is_stale = False

    def add(self, plugin: ScheduledPlugin) -> None:
        """Adds a plugin, with or without work."""
        self._plugins.add(plugin)
        self._is_stale = True

    def remove(self, plugins: AbstractSet[ScheduledPlugin]) -> None:
        """Removes those of these plugins that are in the cache."""
        self._plugins -= plugins
        self._calls = StepCalls([])  # or it would keep them alive until the next step
        self._is_stale = True

    def calls(self, subscriber_revision: object) -> StepCalls:
        """The hooks of the plugins that have work.

        Args:
            subscriber_revision: differs from that of the last call if subscribers have changed.
        """
        if self._is_stale or subscriber_revision != self._subscriber_revision:
            self._subscriber_revision = subscriber_revision
            self._ask_all()
        return self._calls

    def _ask_all(self) -> None:
        # Not stale from here on: plugins that are added or removed meanwhile make it stale again.
        self._is_stale = False
        try:
            with_work = [
                each
                for each in sorted(self._plugins, key=attrgetter("order"))
                if self._has_work(each.plugin) and each in self._plugins
            ]
        except BaseException:
            self._is_stale = True
            raise
        self._calls = StepCalls(with_work)

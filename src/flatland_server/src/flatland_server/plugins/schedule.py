"""Which plugins are to be called in a step."""

from operator import attrgetter
from typing import Callable, Dict, Sequence

from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.scheduled_plugin import ScheduledPlugin, StepCalls, StepHook
from flatland_server.plugins.timer_queue import TimerQueue
from flatland_server.plugins.work_cache import WorkCache
from flatland_server.timekeeper import Timekeeper


class Schedule:
    """Finds the plugins that are due and have work, without asking each of them at every step.

    Plugins with an update rate are in a `TimerQueue`. Those without are due at every step; they are
    in a `WorkCache`.

    Args:
        has_work: asks a plugin; see `Plugin.has_work`. It may remove plugins here.
    """

    def __init__(self, has_work: Callable[[Plugin], bool]) -> None:
        self._has_work = has_work
        self._plugins: Dict[Plugin, ScheduledPlugin] = {}
        self._count = 0
        self._timer_queue = TimerQueue()
        self._work_cache = WorkCache(has_work)

    def add(self, plugin: Plugin, hooks: Dict[str, StepHook]) -> None:
        """Adds a plugin behind all others.

        Args:
            plugin: from now on, it may change its `update_timer` at any time.
            hooks: the step hooks that it overrides, by name.
        """
        self._count += 1
        scheduled = ScheduledPlugin(plugin, hooks, self._count)
        self._plugins[plugin] = scheduled
        self._insert(scheduled)
        plugin.timer_observer = lambda: self._move(scheduled)

    def remove(self, plugins: Sequence[Plugin]) -> None:
        """Removes plugins, and marks them as removed for the calls of the step that is being made.

        Plugins that are not there are ignored.
        """
        removed = {self._plugins.pop(plugin) for plugin in plugins if plugin in self._plugins}
        for each in removed:
            each.is_removed = True
            each.plugin.timer_observer = None
        self._timer_queue.remove(removed)
        self._work_cache.remove(removed)

    def calls(self, timekeeper: Timekeeper, subscriber_revision: object) -> StepCalls:
        """The hooks to call in the step that begins now.

        Args:
            timekeeper: has the time of the step.
            subscriber_revision: differs from that of the last step if subscribers have changed.
        """
        calls = self._work_cache.calls(subscriber_revision)
        if timekeeper.nanoseconds < self._timer_queue.next_due:
            return calls
        due = self._timer_queue.pop_due(timekeeper)
        with_work = [each for each in due if self._has_work(each.plugin) and not each.is_removed]
        return StepCalls(sorted([*calls.plugins, *with_work], key=attrgetter("order")))

    def _insert(self, scheduled: ScheduledPlugin) -> None:
        timer = scheduled.plugin.update_timer
        if timer is not None and timer.period > 0:
            scheduled.timer = timer
            self._timer_queue.add(scheduled)
        else:
            scheduled.timer = None
            self._work_cache.add(scheduled)

    def _move(self, scheduled: ScheduledPlugin) -> None:
        """Moves a plugin to the place where it belongs with the timer that it has now."""
        self._timer_queue.remove({scheduled})
        self._work_cache.remove({scheduled})
        self._insert(scheduled)

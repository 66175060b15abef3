"""Which plugins are to be called in a step."""

import math
from operator import attrgetter
from typing import Callable, Dict, Sequence

from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.scheduled_plugin import ScheduledPlugin, StepCalls, StepHook
from flatland_server.plugins.step_plan import StepPlan
from flatland_server.plugins.timer_queue import TimerQueue
from flatland_server.plugins.work_cache import WorkCache
from flatland_server.timekeeper import Timekeeper


class Schedule:
    """Finds the plugins that are due and have work, without asking each of them at every step.

    Plugins with an update rate are in a `TimerQueue`. Those without are due at every step; they are
    in a `WorkCache`. When a `StepPlan` is made, plugins with an update rate that only publish, and
    have no subscriber, are put into a queue of their own: their timers go on, but no step has to
    wait for them.

    Args:
        has_work: calls `Plugin.has_work` of a plugin. It may remove plugins here.

    Attributes:
        plan: the time until which no plugin is to be called, if known.
    """

    def __init__(self, has_work: Callable[[Plugin], bool]) -> None:
        self.plan = StepPlan()
        self._has_work = has_work
        self._plugins: Dict[Plugin, ScheduledPlugin] = {}
        self._count = 0
        self._timer_queue = TimerQueue()
        self._idle_queue = TimerQueue()
        self._idle_revision: object = None  # of the subscribers when it was filled
        self._idle_is_stale = True  # a plugin may belong there that has come since
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
        self._idle_queue.remove(removed)
        self._work_cache.remove(removed)

    def calls(self, timekeeper: Timekeeper, subscriber_revision: object) -> StepCalls:
        """The hooks to call in the step that begins now.

        Args:
            timekeeper: has the time of the step.
            subscriber_revision: differs from that of the last step if subscribers have changed.
        """
        now = timekeeper.nanoseconds
        idle = self._idle_queue
        if now > idle.next_due:
            idle.pass_over(now - timekeeper.step_nanoseconds)  # steps were made as planned
        if subscriber_revision != self._idle_revision:
            self._end_idleness()
        if now >= idle.next_due:
            idle.pass_over(now)
        calls = self._work_cache.calls(subscriber_revision)
        if now < self._timer_queue.next_due:
            return calls
        due = self._timer_queue.pop_due(timekeeper)
        if self.plan.until > 0:
            self.plan.extend(self._timer_queue.next_due)
        with_work = [each for each in due if self._has_work(each.plugin) and not each.is_removed]
        return StepCalls(sorted([*calls.plugins, *with_work], key=attrgetter("order")))

    def steps_without_calls(
        self, timekeeper: Timekeeper, subscriber_revision: object, limit: int
    ) -> int:
        """The number of steps from now on, up to a limit, in which no hook is to be called.

        This holds until plugins, their timers or subscribers change. Renews the `plan`.

        Args: those of `calls`, and the limit.
        """
        self.pass_over(timekeeper.nanoseconds - timekeeper.step_nanoseconds)
        plan = self.plan
        plan.until, plan.subscriber_revision = 0, subscriber_revision  # plugins may let it expire
        if self._work_cache.calls(subscriber_revision).plugins:
            return 0
        if self._idle_is_stale or subscriber_revision != self._idle_revision:
            self._end_idleness()
            self._idle_revision = subscriber_revision
            self._find_idle()
        next_due = self._timer_queue.next_due
        if self._idle_is_stale:
            plan.expire()  # a plugin may have no work once it has been due
        elif plan.subscriber_revision is not None:
            plan.extend(next_due)
        if math.isinf(next_due):
            return limit
        steps = -(int(timekeeper.nanoseconds - next_due) // timekeeper.step_nanoseconds)
        return min(max(steps, 0), limit)

    def pass_over(self, nanoseconds: int) -> None:
        """Makes idle plugins due after this simulated time [ns], at which a step was made."""
        self._idle_queue.pass_over(nanoseconds)

    def _find_idle(self) -> None:
        """Moves plugins that only publish, and have no work, to the queue of the idle ones."""
        candidates = [each for each in self._timer_queue.plugins if _only_publishes(each.plugin)]
        # The time of a plugin is counted from the step in which it is due first.
        started = [each for each in candidates if each.timer and each.timer.due >= 0]
        self._idle_is_stale = len(started) < len(candidates)
        without_work = [each for each in started if not self._has_work(each.plugin)]
        idle = {each for each in without_work if each.timer and not each.is_removed}
        self._timer_queue.remove(idle)
        for each in idle:
            self._idle_queue.add(each)

    def _end_idleness(self) -> None:
        """Moves all idle plugins back to the others."""
        self._idle_is_stale = True
        idle = self._idle_queue.plugins
        if idle:
            self._idle_queue.remove(set(idle))
            for each in idle:
                self._timer_queue.add(each)

    def _insert(self, scheduled: ScheduledPlugin) -> None:
        timer = scheduled.plugin.update_timer
        if timer is not None and timer.period > 0:
            scheduled.timer = timer
            self._timer_queue.add(scheduled)
            self._idle_is_stale = True
        else:
            scheduled.timer = None
            self._work_cache.add(scheduled)

    def _move(self, scheduled: ScheduledPlugin) -> None:
        """Moves a plugin to the place where it belongs with the timer that it has now."""
        self.plan.expire()
        self._timer_queue.remove({scheduled})
        self._idle_queue.remove({scheduled})
        self._work_cache.remove({scheduled})
        self._insert(scheduled)


def _only_publishes(plugin: Plugin) -> bool:
    """Whether the class that has the plugin's `has_work`, or one derived from it, says so."""
    for each in type(plugin).__mro__:
        if "only_publishes" in vars(each):
            return plugin.only_publishes
        if "has_work" in vars(each):
            break
    return False

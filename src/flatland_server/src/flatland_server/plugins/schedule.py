"""The schedule: the plugins to call in a step, and the number of steps that call none.

    state    a plugin                      its step hooks are called
    steady   without a rate, with work     in every step; or the core writes its `step_messages`
    timed    with a rate and with work     when its `update_timer` is due
    idle     without work                  never; its timer goes on

A plugin has work if its `has_work` returns so. `Schedule._ask_all` calls it for all plugins, and
finds their states: at the start of a step, if since the last time topics have got or lost
subscribers, plugins were started or stopped, or one has set its `update_timer`. In other steps no
plugin is asked anything; one in which none is due costs the same for any number of timed plugins.
"""

import math
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from operator import attrgetter
from typing import Callable, Dict, List, Optional, Sequence, Tuple, Union

from flatland_server._core import StepMessage, StepMessages
from flatland_server.plugins.plugin import STEP_HOOKS, Plugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer

StepHook = Callable[[Timekeeper], None]

Work = Union[bool, List[StepMessage]]
"""Whether the hooks of a plugin are to be called, or the messages in their place."""

_FOREVER = 2**63
"""A time that is never reached [ns]; an int, since ints are compared faster with ints."""

_EXPIRED = object()
"""The subscriber revision of a plan that has expired."""


class StepPlan:
    """The simulated time before which no hook of a plugin is to be called.

    Attributes:
        until: the time [ns] of the next step that calls a hook; 0 if each step may call one.
        messages: what the core writes before each step; None: nothing.
        subscriber_revision: of the transport when the plan was made; it is valid only as long as
            the subscribers are the same.
    """

    __slots__ = ("messages", "subscriber_revision", "until")

    def __init__(self) -> None:
        self.expire()

    def expire(self) -> None:
        """Drops the plan: plugins, or their timers, have changed."""
        self.until = 0
        self.messages: Optional[StepMessages] = None
        self.subscriber_revision: object = _EXPIRED


@dataclass(eq=False)
class ScheduledPlugin:
    """A plugin with the step hooks that it overrides, by name."""

    plugin: Plugin
    hooks: Dict[str, StepHook]
    order: int
    """Unique; plugins are called in this order, in which they were started."""
    timer: Optional[UpdateTimer] = None
    """The timer that says when it is due; None: at every step."""
    is_idle: bool = False
    is_removed: bool = False


class StepCalls:
    """The hooks to call in a step.

    Args:
        plugins: the plugins to call, in their order.

    Attributes:
        hooks: with their plugins, by the name of the hook.
    """

    def __init__(self, plugins: List[ScheduledPlugin]) -> None:
        self.plugins = plugins
        self.hooks: Dict[str, List[Tuple[ScheduledPlugin, StepHook]]] = {
            name: [(each, each.hooks[name]) for each in plugins if name in each.hooks]
            for name in STEP_HOOKS
        }


NO_CALLS = StepCalls([])


class Schedule:
    """The plugins that have step hooks, each in one of the states above.

    Args:
        work_of: calls `has_work` and `step_messages` of a plugin. It may add and remove plugins
            here.
        has_contact_hooks: returns whether a plugin has a hook that any step may call.

    Attributes:
        plan: must be made to expire when plugins with other hooks are started or stopped.
        messages: what the core writes in each step, in the order of the plugins; None: nothing.
    """

    def __init__(
        self, work_of: Callable[[Plugin], Work], has_contact_hooks: Callable[[], bool]
    ) -> None:
        self.plan = StepPlan()
        self.messages: Optional[StepMessages] = None
        self._work_of = work_of
        self._has_contact_hooks = has_contact_hooks
        self._plugins: Dict[Plugin, ScheduledPlugin] = {}  # in the order of their calls
        self._count = 0
        self._steady = NO_CALLS
        self._timed: List[Tuple[float, int, ScheduledPlugin]] = []  # a heap: due [ns], order
        self._next_due = math.inf  # the least of the heap
        self._may_plan = False  # no plugin has to be called in every step

    def add(self, plugin: Plugin, hooks: Dict[str, StepHook]) -> None:
        """Adds a plugin behind all others.

        Args:
            plugin: from now on, it may change its `update_timer` at any time.
            hooks: the step hooks that it overrides, by name.
        """
        self._count += 1
        self._plugins[plugin] = ScheduledPlugin(plugin, hooks, self._count)
        plugin.timer_observer = self.plan.expire
        self.plan.expire()

    def remove(self, plugins: Sequence[Plugin]) -> None:
        """Removes plugins, and marks them as removed for the calls of the step that is being made.

        Plugins that are not there are ignored.
        """
        for plugin in plugins:
            scheduled = self._plugins.pop(plugin, None)
            if scheduled is not None:
                scheduled.is_removed = True
                plugin.timer_observer = None
        # Found again in the next step; until then, they would keep plugins alive.
        self._steady, self._timed, self._next_due = NO_CALLS, [], math.inf
        self.messages = None
        self.plan.expire()

    def calls(self, timekeeper: Timekeeper, subscriber_revision: object) -> StepCalls:
        """The hooks to call in the step that begins now.

        Args:
            timekeeper: gives the time of the step.
            subscriber_revision: differs from that of the last step if subscribers have changed.
        """
        if subscriber_revision != self.plan.subscriber_revision:
            self._ask_all(timekeeper, subscriber_revision)
        if timekeeper.nanoseconds < self._next_due:
            return self._steady
        due = self._pop_due(timekeeper.nanoseconds)
        return StepCalls(sorted([*self._steady.plugins, *due], key=attrgetter("order")))

    def steps_without_calls(
        self, timekeeper: Timekeeper, subscriber_revision: object, limit: int
    ) -> int:
        """The number of steps from now on, up to a limit, in which no step hook is to be called.

        This holds until plugins, their timers or subscribers change.

        Args: those of `calls`, and the limit.
        """
        if subscriber_revision != self.plan.subscriber_revision:
            self._ask_all(timekeeper, subscriber_revision)
        if self._steady.plugins or self.messages or self.plan.subscriber_revision is _EXPIRED:
            return 0
        if math.isinf(self._next_due):
            return limit
        steps = -(int(timekeeper.nanoseconds - self._next_due) // timekeeper.step_nanoseconds)
        return min(max(steps, 0), limit)

    def pass_over(self, nanoseconds: int) -> None:
        """Makes idle plugins due after this simulated time [ns], at which a step was made."""
        for each in self._plugins.values():
            if each.is_idle and each.timer is not None:
                each.timer.check_update_at(nanoseconds)

    def renew_plan(self) -> None:
        """Plans until the next plugin is due; to be called after a step that has called hooks."""
        if self._may_plan and self.plan.subscriber_revision is not _EXPIRED:
            due = self._next_due
            self.plan.until = math.ceil(due) if due < _FOREVER else _FOREVER
            self.plan.messages = self.messages

    def _ask_all(self, timekeeper: Timekeeper, subscriber_revision: object) -> None:
        """Finds the state of each plugin at the start of a step, and makes a plan.

        Plugins that are added meanwhile are called from the next step on.
        """
        now = timekeeper.nanoseconds
        self.pass_over(now - timekeeper.step_nanoseconds)
        self.plan.expire()
        self.plan.subscriber_revision = subscriber_revision  # expires if plugins change meanwhile
        steady: List[ScheduledPlugin] = []
        timed: List[Tuple[float, int, ScheduledPlugin]] = []
        messages: List[Tuple[int, StepMessage]] = []
        try:
            for each in list(self._plugins.values()):
                work = not each.is_removed and self._work_of(each.plugin)
                each.is_idle = work is False
                timer = each.plugin.update_timer
                timer = each.timer = timer if timer is not None and timer.period > 0 else None
                if each.is_idle:
                    if timer is not None and timer.due < 0:
                        timer.check_update_at(now)  # a rate counts from the first step
                elif timer is None and isinstance(work, list):
                    messages += [(each.order, message) for message in work]
                elif timer is None:
                    steady.append(each)
                else:
                    timed.append((timer.due, each.order, each))
        except BaseException:
            self.plan.expire()
            raise
        heapify(timed)
        self._steady, self._timed = StepCalls(steady), timed
        self._next_due = timed[0][0] if timed else math.inf
        self._may_plan = not steady and not self._has_contact_hooks()
        self.messages = _in_order(messages)
        self.renew_plan()

    def _pop_due(self, now: int) -> List[ScheduledPlugin]:
        """The timed plugins that are due now [ns]; each is queued again for its next time."""
        reached = []
        while self._timed and self._timed[0][0] <= now:
            reached.append(heappop(self._timed)[2])
        due = []
        for each in reached:
            assert each.timer is not None
            if each.timer.check_update_at(now):  # or the plugin has asked its timer itself
                due.append(each)
            heappush(self._timed, (each.timer.due, each.order, each))
        self._next_due = self._timed[0][0]
        return due


def _in_order(messages: Sequence[Tuple[int, StepMessage]]) -> Optional[StepMessages]:
    """Messages of plugins, each with the plugin's order."""
    if not messages:
        return None
    in_order = StepMessages()
    for order, message in messages:
        in_order.add(order, message)
    return in_order

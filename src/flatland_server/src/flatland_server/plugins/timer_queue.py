"""Plugins with an update rate, ordered by the time at which each is due next."""

import math
from heapq import heapify, heappop, heappush
from typing import AbstractSet, List, Tuple

from flatland_server.plugins.scheduled_plugin import ScheduledPlugin
from flatland_server.timekeeper import Timekeeper


class TimerQueue:
    """A heap, so that a step in which no plugin is due costs the same for any number of them."""

    def __init__(self) -> None:
        self._heap: List[Tuple[float, int, ScheduledPlugin]] = []  # due [ns], order, plugin
        self.next_due = math.inf
        """The simulated time at which the next plugin is due [ns]."""

    def add(self, plugin: ScheduledPlugin) -> None:
        """Queues a plugin that has a timer."""
        assert plugin.timer is not None
        heappush(self._heap, (plugin.timer.due, plugin.order, plugin))
        self.next_due = self._heap[0][0]

    @property
    def plugins(self) -> List[ScheduledPlugin]:
        """Those that are queued, in any order."""
        return [item[2] for item in self._heap]

    def remove(self, plugins: AbstractSet[ScheduledPlugin]) -> None:
        """Removes those of these plugins that are in the queue."""
        self._heap = [item for item in self._heap if item[2] not in plugins]
        heapify(self._heap)
        self.next_due = self._heap[0][0] if self._heap else math.inf

    def pop_due(self, timekeeper: Timekeeper) -> List[ScheduledPlugin]:
        """The plugins that are due now, in any order; each is queued again for its next time."""
        reached = []
        while self._heap and self._heap[0][0] <= timekeeper.nanoseconds:
            reached.append(heappop(self._heap)[2])
        # A plugin may have asked its timer itself; then it is due later than it was queued for.
        due = [each for each in reached if each.timer and each.timer.check_update(timekeeper)]
        for each in reached:
            self.add(each)
        return due

    def pass_over(self, now: int) -> None:
        """Makes each plugin due after this simulated time [ns], as if it had been popped till then.

        Each of them has been due before.
        """
        while self._heap and self._heap[0][0] <= now:
            plugin = heappop(self._heap)[2]
            assert plugin.timer is not None
            plugin.timer.check_update_at(now)
            self.add(plugin)
        self.next_due = self._heap[0][0] if self._heap else math.inf

"""Plugins with an update rate, by the time at which each is due next."""

from heapq import heapify, heappop, heappush
from typing import AbstractSet, List, Tuple

from flatland_server.plugins.scheduled_plugin import ScheduledPlugin
from flatland_server.timekeeper import Timekeeper


class TimerQueue:
    """A heap, so that a step in which no plugin is due costs the same for any number of them."""

    def __init__(self) -> None:
        self._heap: List[Tuple[float, int, ScheduledPlugin]] = []  # due [ns], order, plugin

    def add(self, plugin: ScheduledPlugin) -> None:
        """Queues a plugin that has a timer."""
        assert plugin.timer is not None
        heappush(self._heap, (plugin.timer.due, plugin.order, plugin))

    def remove(self, plugins: AbstractSet[ScheduledPlugin]) -> None:
        """Removes those of these plugins that are in the queue."""
        self._heap = [item for item in self._heap if item[2] not in plugins]
        heapify(self._heap)

    def pop_due(self, timekeeper: Timekeeper) -> List[ScheduledPlugin]:
        """The plugins that are due now, in any order; each is queued again for its next time."""
        now = timekeeper.nanoseconds
        if not self._heap or self._heap[0][0] > now:
            return []
        reached = []
        while self._heap and self._heap[0][0] <= now:
            reached.append(heappop(self._heap)[2])
        # A plugin may have asked its timer itself; then it is due later than it was queued for.
        due = [each for each in reached if each.timer and each.timer.check_update(timekeeper)]
        for each in reached:
            self.add(each)
        return due

"""Which plugins have something to do in a step."""

from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from operator import attrgetter
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from flatland_server.plugins.plugin import STEP_HOOKS, Plugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer

Hook = Callable[[Timekeeper], None]


@dataclass(eq=False)
class Entry:
    """A plugin, and those of the hooks around a step that it overrides, by name."""

    plugin: Plugin
    hooks: Dict[str, Hook]
    order: int = 0
    timer: Optional[UpdateTimer] = None
    is_gone: bool = False


class Due:
    """The plugins of a step, and what is to be called of them, in their order."""

    def __init__(self, entries: List[Entry]) -> None:
        self.entries = entries
        self.calls: Dict[str, List[Tuple[Entry, Hook]]] = {
            name: [(entry, entry.hooks[name]) for entry in entries if name in entry.hooks]
            for name in STEP_HOOKS
        }
        """By the hooks' names."""


class Schedule:
    """Finds the plugins that are due, without asking each of them at every step.

    Those with a rate wait in a heap for the time at which they are due next. Those without one are
    due at every step, unless they have no work: that is asked when somebody begins or ends to
    listen to something, and otherwise taken to be as it was.

    Args:
        has_work: asks a plugin; see `Plugin.has_work`.
    """

    def __init__(self, has_work: Callable[[Plugin], bool]) -> None:
        self._has_work = has_work
        self._entries: List[Entry] = []  # in the order of their hooks
        self._count = 0
        self._steady = Due([])  # those that are due at every step, and have work
        self._waiting: List[Tuple[float, int, Entry]] = []  # a heap by time [ns]
        self._version: object = None
        self._is_stale = False

    def add(self, entry: Entry) -> None:
        """Appends a plugin."""
        self._count += 1
        entry.order = self._count
        self._entries.append(entry)
        self._place(entry)
        entry.plugin.on_new_timer = lambda: self._place_anew(entry)

    def remove(self, plugins: Sequence[Plugin]) -> None:
        """Takes plugins off; also in the midst of a step, whose entries are marked then."""
        gone = set(plugins)
        for entry in self._entries:
            if entry.plugin in gone:
                entry.is_gone = True
                entry.plugin.on_new_timer = None
        self._entries = [entry for entry in self._entries if not entry.is_gone]
        self._waiting = [item for item in self._waiting if not item[2].is_gone]
        heapify(self._waiting)
        self._is_stale = True

    def due(self, timekeeper: Timekeeper, subscriber_revision: object) -> Due:
        """Whose hooks are to be called in this step.

        Args:
            timekeeper: which step it is.
            subscriber_revision: another value than before if listeners have come or gone.
        """
        if self._is_stale or subscriber_revision != self._version:
            self._version = subscriber_revision
            self._is_stale = False
            self._steady = Due(
                [entry for entry in self._entries if entry.timer is None and self._works(entry)]
            )
        now = timekeeper.nanoseconds
        if not self._waiting or self._waiting[0][0] > now:
            return self._steady
        awake = []
        while self._waiting and self._waiting[0][0] <= now:
            awake.append(heappop(self._waiting)[2])
        timed = [entry for entry in awake if entry.timer.check_update(timekeeper)]  # type: ignore[union-attr]
        for entry in awake:
            self._wait(entry)
        at_work = [entry for entry in timed if self._works(entry)]
        if not at_work:
            return self._steady
        return Due(sorted([*self._steady.entries, *at_work], key=attrgetter("order")))

    def _works(self, entry: Entry) -> bool:
        return self._has_work(entry.plugin) and not entry.is_gone

    def _place(self, entry: Entry) -> None:
        timer = entry.plugin.update_timer
        entry.timer = timer if timer is not None and timer.period > 0 else None
        if entry.timer is None:
            self._is_stale = True
        else:
            self._wait(entry)

    def _wait(self, entry: Entry) -> None:
        if entry.timer is not None:
            heappush(self._waiting, (entry.timer.due, entry.order, entry))

    def _place_anew(self, entry: Entry) -> None:
        """Its timer is another one now."""
        self._waiting = [item for item in self._waiting if item[2] is not entry]
        heapify(self._waiting)
        self._is_stale = True
        self._place(entry)

"""TimerQueue alone: which plugins with an update rate are due at which step."""

import math
from types import SimpleNamespace
from typing import Any, List

import pytest

from flatland_server.plugins.scheduled_plugin import ScheduledPlugin
from flatland_server.plugins.timer_queue import TimerQueue
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer


def plugin(name: str, rate: float) -> ScheduledPlugin:
    """A plugin with an update rate [Hz]."""
    thing: Any = SimpleNamespace(name=name)
    return ScheduledPlugin(thing, {}, order=ord(name[0]), timer=UpdateTimer(rate))


@pytest.fixture
def timekeeper() -> Timekeeper:
    return Timekeeper(0.01)


@pytest.fixture
def queue() -> TimerQueue:
    return TimerQueue()


def due_names(queue: TimerQueue, timekeeper: Timekeeper, steps: int) -> List[str]:
    """The names of the plugins that are due, one string a step."""
    names = []
    for _ in range(steps):
        names.append("".join(sorted(each.plugin.name for each in queue.pop_due(timekeeper))))
        timekeeper.step()
    return names


def test_an_empty_queue_has_nothing_due(queue, timekeeper):
    assert queue.pop_due(timekeeper) == []


def test_each_plugin_is_due_at_once_and_then_at_its_rate(queue, timekeeper):
    for name, rate in (("a", 50.0), ("b", 25.0), ("c", 100.0)):
        queue.add(plugin(name, rate))

    assert due_names(queue, timekeeper, 5) == ["abc", "c", "ac", "c", "abc"]


def test_a_plugin_that_is_added_later_counts_from_then(queue, timekeeper):
    queue.add(plugin("a", 50.0))
    assert due_names(queue, timekeeper, 3) == ["a", "", "a"]

    queue.add(plugin("b", 50.0))

    assert due_names(queue, timekeeper, 4) == ["b", "a", "b", "a"]


def test_removed_plugins_are_not_due_and_the_others_still_are(queue, timekeeper):
    plugins = [plugin(name, rate) for name, rate in zip("abcde", (10, 50, 20, 50, 100))]
    for each in plugins:
        queue.add(each)
    due_names(queue, timekeeper, 1)

    queue.remove({plugins[0], plugins[3], plugin("unknown", 1.0)})

    assert " ".join(due_names(queue, timekeeper, 10)) == "e be e be ce be e be e bce"


def test_a_plugin_that_has_asked_its_timer_itself_is_due_later(queue, timekeeper):
    own = plugin("a", 50.0)
    queue.add(own)
    due_names(queue, timekeeper, 2)

    assert own.timer.check_update(timekeeper)

    assert due_names(queue, timekeeper, 3) == ["", "", "a"]


def test_the_queue_knows_when_the_next_plugin_is_due(queue, timekeeper):
    assert queue.next_due == math.inf
    first = plugin("a", 20.0)
    queue.add(first)
    assert queue.next_due <= 0
    due_names(queue, timekeeper, 1)
    assert queue.next_due == 50_000_000
    queue.add(plugin("b", 50.0))
    due_names(queue, timekeeper, 1)
    assert queue.next_due == 30_000_000

    queue.remove({first})
    assert queue.next_due == 30_000_000

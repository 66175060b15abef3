"""WorkCache alone: which plugins are called at every step, and when they are asked for work."""

from types import SimpleNamespace
from typing import Any, Callable, Dict, List

import pytest

from flatland_server.plugins.scheduled_plugin import ScheduledPlugin
from flatland_server.plugins.work_cache import WorkCache


class Plugins:
    """Plugins that are asked for work, by name."""

    def __init__(self) -> None:
        self.asked: List[str] = []
        self.without_work: List[str] = []
        self.on_ask: Dict[str, Callable[[], None]] = {}
        self.cache = WorkCache(self._has_work)

    def add(self, name: str, order: int) -> ScheduledPlugin:
        thing: Any = SimpleNamespace(name=name)
        plugin = ScheduledPlugin(thing, {}, order)
        self.cache.add(plugin)
        return plugin

    def called(self, subscriber_revision: object = 1) -> List[str]:
        """The names of the plugins that are called."""
        calls = self.cache.calls(subscriber_revision)
        return [each.plugin.name for each in calls.plugins]

    def _has_work(self, plugin: Any) -> bool:
        self.asked.append(plugin.name)
        self.on_ask.pop(plugin.name, lambda: None)()
        return plugin.name not in self.without_work


@pytest.fixture
def plugins() -> Plugins:
    return Plugins()


def test_plugins_with_work_are_called_in_their_order(plugins):
    for name, order in (("c", 3), ("a", 1), ("b", 2)):
        plugins.add(name, order)
    plugins.without_work = ["a"]

    assert plugins.called() == ["b", "c"]


def test_plugins_are_asked_again_only_when_the_subscribers_have_changed(plugins):
    plugins.add("a", 1)
    assert [plugins.called(revision) for revision in (1, 1, 1)] == [["a"]] * 3
    assert plugins.asked == ["a"]

    plugins.without_work = ["a"]
    assert plugins.called(1) == ["a"]
    assert plugins.called(2) == []
    assert plugins.asked == ["a", "a"]


def test_plugins_are_asked_again_when_one_was_added_or_removed(plugins):
    plugins.add("a", 1)
    plugins.called()

    b = plugins.add("b", 2)
    assert plugins.called() == ["a", "b"]
    plugins.cache.remove({b})
    assert plugins.called() == ["a"]

    assert plugins.asked == ["a", "a", "b", "a"]


def test_a_plugin_that_is_removed_while_it_is_asked_is_not_called(plugins):
    a, _ = plugins.add("a", 1), plugins.add("b", 2)
    plugins.on_ask["a"] = lambda: plugins.cache.remove({a})

    assert plugins.called() == ["b"]
    assert plugins.called() == ["b"]


def test_plugins_that_are_added_while_one_is_asked_are_called_from_the_next_step_on(plugins):
    plugins.add("a", 1)
    plugins.on_ask["a"] = lambda: plugins.add("b", 2)

    assert plugins.called() == ["a"]
    assert plugins.called() == ["a", "b"]


def test_all_plugins_are_asked_again_after_an_interrupt(plugins):
    def interrupt() -> None:
        raise KeyboardInterrupt

    plugins.add("a", 1)
    plugins.add("b", 2)
    plugins.on_ask["b"] = interrupt

    with pytest.raises(KeyboardInterrupt):
        plugins.called()

    assert plugins.called() == ["a", "b"]

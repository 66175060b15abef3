"""A plugin that holds up the simulation is named; quick ones that run meanwhile are not."""

from types import SimpleNamespace

import pytest

from flatland_server.plugins.plugin import Plugin
from flatland_server.simulation.slow_plugin_watch import SlowPluginWatch


class Running(Plugin):
    """A plugin in the middle of a hook."""

    def __init__(self, owner):
        self.node = SimpleNamespace(owner=owner)
        self._hook = self.hook()
        next(self._hook)

    def hook(self):
        yield

    @property
    def frame(self):
        return self._hook.gi_frame


@pytest.fixture
def watch(monkeypatch):
    """A watch that was updated at time 0, with a thread that does nothing."""
    monkeypatch.setattr(SlowPluginWatch, "_watch", lambda self: None)
    watch = SlowPluginWatch()
    watch._latest = 0.0
    return watch


def test_a_plugin_that_runs_for_long_is_named_once(watch, caplog):
    slow = Running("robot/slow")
    for now in (0.4, 0.9, 1.4, 1.9, 2.4):
        watch._look(slow.frame, now)

    [record] = caplog.records
    assert 'held up for more than 1 s by the plugin "robot/slow"' in record.getMessage()


def test_many_quick_plugins_are_not_named(watch, caplog):
    plugins = [Running(f"robot{number}/drive") for number in range(5)]
    for number, plugin in enumerate(plugins):
        watch._look(plugin.frame, 0.5 * number)
    watch._look(None, 3.0)

    assert caplog.records == []

"""Keys of plugins as lenient as those of the original, where it does no harm."""

import sys

import pytest

from flatland_server import ModelPlugin, PluginDeclaration, PluginLoader, YamlReader
from flatland_server.testing import refusal, robot


class Horn(ModelPlugin):
    """Reads one key."""

    def on_initialize(self, config: YamlReader) -> None:
        self.volume = config.get_float("volume", 1.0)
        config.finish()


class LenientHorn(Horn):
    """Takes any keys besides."""

    accept_other_keys = True


@pytest.fixture
def loader(monkeypatch):
    """Knows both, under a module's name that can be imported."""
    monkeypatch.setitem(sys.modules, __name__, sys.modules[Horn.__module__])
    return PluginLoader([PluginDeclaration.of(Horn), PluginDeclaration.of(LenientHorn)])


def test_a_plugin_may_accept_keys_that_it_does_not_read(loader):
    entry = "name: horn, colour: red"

    assert 'unknown key "colour"' in refusal(f"type: Horn, {entry}", loader=loader)
    robot(f"type: LenientHorn, {entry}", loader=loader)


def test_the_last_of_two_equal_keys_counts_with_a_warning(caplog, loader):
    world = robot("type: Horn, name: horn, volume: 2, volume: 3", loader=loader).world

    [horn] = world.plugins_of("robot").values()
    assert horn.volume == 3.0
    [warning] = [record.getMessage() for record in caplog.records]
    assert 'the key "volume" is given twice; the last one counts' in warning

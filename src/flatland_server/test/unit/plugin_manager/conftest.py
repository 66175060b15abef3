"""The plugins of the tests of the plugin manager."""

from typing import Iterator

import pytest
from plugin_manager.recorders import (
    Dice,
    OnlyAfter,
    Recorder,
    Toucher,
    Unfinished,
    WorldRecorder,
    calls,
)

from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader


@pytest.fixture(autouse=True)
def _forget_calls() -> Iterator[None]:
    calls.clear()
    yield
    calls.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of these tests."""
    classes = (Recorder, Toucher, WorldRecorder, OnlyAfter, Dice, Unfinished)
    return PluginLoader(map(PluginDeclaration.of, classes))

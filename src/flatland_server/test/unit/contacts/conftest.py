"""The plugins and the room of the tests of contacts."""

from typing import Iterator

import pytest
from contacts.room import Listener, NoContactHooks, OnlyBegin, Room, WorldListener, actions, calls

from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    yield
    calls.clear()
    actions.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of these tests."""
    classes = (Listener, WorldListener, OnlyBegin, NoContactHooks)
    return PluginLoader(map(PluginDeclaration.of, classes))


@pytest.fixture
def room(files, simulate) -> Room:
    return Room(files, simulate)

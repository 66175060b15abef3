"""The plugins of the tests of contacts, and the room that they are in."""

from typing import Iterator

import pytest
from contacts.room import Deaf, Listener, OnlyBegin, Room, WorldListener, calls, deeds

from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    yield
    calls.clear()
    deeds.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of these tests."""
    classes = (Listener, WorldListener, OnlyBegin, Deaf)
    return PluginLoader(map(PluginDeclaration.of, classes))


@pytest.fixture
def room(files, simulate) -> Room:
    return Room(files, simulate)

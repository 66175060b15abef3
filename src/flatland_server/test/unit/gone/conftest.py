"""The plugins and the world of the tests of objects that are kept after their end."""

from typing import Iterator

import pytest
from gone.keepers import ROBOT, Failing, Keeper, WorldKeeper, kept, lean_on_wall

from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.world import World


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    yield
    kept.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of these tests."""
    return PluginLoader(map(PluginDeclaration.of, (Keeper, WorldKeeper, Failing)))


@pytest.fixture
def world(files) -> World:
    return lean_on_wall(files, ROBOT)

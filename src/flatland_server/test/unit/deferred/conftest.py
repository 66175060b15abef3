"""The plugins and the world of the tests of deferred changes."""

from typing import Iterator

import pytest
from deferred.stage import Actor, Founder, Stage, ends, plans, starts

from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    yield
    for each in (plans, starts, ends):
        each.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of these tests."""
    return PluginLoader(map(PluginDeclaration.of, (Actor, Founder)))


@pytest.fixture
def stage(files, simulate) -> Iterator[Stage]:
    stage = Stage(files, simulate)
    yield stage
    assert plans == {}
    stage.check()
    stage.run(0.5)
    stage.check()

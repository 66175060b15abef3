"""The plugins, the transport and the model files of the tests of the world."""

import pytest
from world.parts import BODIES, Failing, Herald, Talker

from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.transport.local_transport import LocalTransport


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of these tests."""
    return PluginLoader(map(PluginDeclaration.of, (Talker, Failing, Herald)))


@pytest.fixture
def transport() -> LocalTransport:
    return LocalTransport()


@pytest.fixture
def models(files):
    """A folder with model files; the third plugin of bad.yaml does not start."""
    files.write("plain.yaml", BODIES)
    good = f"{BODIES}plugins:\n  - {{type: Talker, name: a}}\n"
    files.write("good.yaml", good)
    files.write(
        "bad.yaml", f"{good}  - {{type: Talker, name: b}}\n  - {{type: Failing, name: c}}\n"
    )
    return files

"""What the unit tests of the server share: worlds out of YAML text, and simulated time."""

from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable

import hypothesis
import pytest

from flatland_server import PluginLoader, World
from flatland_server.testing import Simulation, WorldFiles

pytest.register_assert_rewrite(
    "deferred.stage", "plugin_manager.recorders", "world.parts", "yaml_reader.reading"
)

# Equal cases in every run, and no files left behind.
hypothesis.settings.register_profile("flatland", derandomize=True, database=None, deadline=None)
hypothesis.settings.load_profile("flatland")


class Files(WorldFiles):
    """A folder of world, model and map files, whose worlds are not stepped yet."""

    def load(self, world: str, **options: Any) -> World:
        return super().load(world, **options).world


@pytest.fixture
def unpatched_rospy(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Undoes patches of rospy after the test; rospy's own class of connections."""
    from rospy import topics
    from rospy.impl import tcpros_base

    monkeypatch.setattr(topics, "QueuedConnection", topics.QueuedConnection)
    rospys = SimpleNamespace(
        start_server=lambda: None,
        tcp_ros_server=SimpleNamespace(server_sock=SimpleNamespace(listen=lambda _: None)),
    )
    monkeypatch.setattr(tcpros_base, "_tcpros_server", rospys)
    return topics.QueuedConnection


@pytest.fixture(scope="session")
def loader() -> PluginLoader:
    """The plugins of this workspace, looked up once."""
    return PluginLoader()


@pytest.fixture
def files(tmp_path: Path, loader: PluginLoader) -> Files:
    return Files(tmp_path, loader)


@pytest.fixture
def simulate() -> Callable[..., Simulation]:
    """Makes a `Simulation` of a world, whose plugins may fail."""
    return partial(Simulation, allow_failures=True)

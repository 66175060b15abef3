"""What the unit tests of the server share: worlds out of YAML text, and simulated time."""

import textwrap
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Optional, Type

import hypothesis
import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport

pytest.register_assert_rewrite(
    "deferred.stage", "plugin_manager.recorders", "world.parts", "yaml_reader.reading"
)

# Equal cases in every run, and no files left behind.
hypothesis.settings.register_profile("flatland", derandomize=True, database=None, deadline=None)
hypothesis.settings.load_profile("flatland")


class WorldFiles:
    """A folder of world, model and map files."""

    def __init__(self, folder: Path, loader: PluginLoader) -> None:
        self.folder = folder
        self._loader = loader

    def write(self, name: str, text: str) -> Path:
        """Writes a file; the text may be indented as a whole."""
        path = self.folder / name
        path.write_text(textwrap.dedent(text).lstrip("\n"), encoding="utf-8")
        return path

    def load(self, text: str, **options: Any) -> World:
        """Writes a world file and loads it."""
        path = self.write("world.yaml", text)
        return World.from_file(path, **{"loader": self._loader, **options})

    def refusal(self, text: str) -> str:
        """Why a world file is not loaded, without the folder's name."""
        with pytest.raises(FlatlandError) as caught:
            self.load(text)
        return str(caught.value).replace(f"{self.folder}/", "")


class Simulation:
    """A world that is stepped, with the messages that wait for it."""

    def __init__(self, world: World, step_size: float = 0.005) -> None:
        self.world = world
        self.timekeeper = Timekeeper(step_size)

    @property
    def transport(self) -> LocalTransport:
        """What the world publishes to."""
        assert isinstance(self.world.transport, LocalTransport)
        return self.world.transport

    def run(self, seconds: Optional[float] = None) -> None:
        """Lets simulated time pass: one step, or so many seconds."""
        steps = 1 if seconds is None else round(seconds / self.timekeeper.step_size)
        for _ in range(steps):
            self.world.transport.process()
            self.world.step(self.timekeeper)


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
def files(tmp_path: Path, loader: PluginLoader) -> WorldFiles:
    return WorldFiles(tmp_path, loader)


@pytest.fixture
def simulate() -> Type[Simulation]:
    """Makes a `Simulation` of a world."""
    return Simulation

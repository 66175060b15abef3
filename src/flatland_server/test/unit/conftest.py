"""Shared by the unit tests of the server: worlds from YAML text, and simulated time."""

import socket
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable, Iterator

import hypothesis
import pytest

from flatland_server import PluginLoader, World
from flatland_server.testing import Harness, WorldFiles

pytest.register_assert_rewrite(
    "deferred.stage", "plugin_manager.recorders", "world.parts", "yaml_reader.reading"
)

# Equal cases in every run, and no files left behind.
hypothesis.settings.register_profile("flatland", derandomize=True, database=None, deadline=None)
hypothesis.settings.load_profile("flatland")


class Files(WorldFiles):
    """A folder of world, model and map files; its worlds are not stepped yet."""

    def load(self, world: str, **options: Any) -> World:
        return super().load(world, **options).world


@pytest.fixture
def unpatched_rospy(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Undoes patches of rospy after the test; rospy's own class of connections."""
    from rospy import msg, topics
    from rospy.impl import registration, tcpros_base
    from rospy.impl.statistics import SubscriberStatisticsLogger

    for owner, name in (
        (topics, "QueuedConnection"),
        (topics, "Poller"),
        (msg, "deserialize_messages"),
        (tcpros_base, "deserialize_messages"),
        (SubscriberStatisticsLogger, "is_enabled"),
    ):
        monkeypatch.setattr(owner, name, getattr(owner, name))
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen(5)
        server = SimpleNamespace(server_sock=listening, inbound_handler=lambda *_: None)
        rospys = SimpleNamespace(
            start_server=lambda: None,
            tcp_ros_server=server,
            topic_connection_handler=lambda *_: None,
        )
        monkeypatch.setattr(tcpros_base, "_tcpros_server", rospys)
        manager = SimpleNamespace(
            master_uri="http://127.0.0.1:9", uri="http://here:2", publisher_update=lambda *_: None
        )
        listeners = registration.RegistrationListeners()
        listeners.listeners = [manager]
        monkeypatch.setattr(registration, "_registration_listeners", listeners)
        # No threads, which would outlive the test, and no master.
        patches = "flatland_server.ros.rospy_patches"
        monkeypatch.setattr(f"{patches}.registration.Registrar.start", lambda self: None)
        monkeypatch.setattr(f"{patches}.registration._keep_parameters", lambda: None)
        handshakes = lambda handle: SimpleNamespace(add=handle)  # noqa: E731
        monkeypatch.setattr(f"{patches}.tcpros_server.Handshakes", handshakes)
        yield topics.QueuedConnection


@pytest.fixture(scope="session")
def loader() -> PluginLoader:
    """The plugins of this workspace, looked up once."""
    return PluginLoader()


@pytest.fixture
def files(tmp_path: Path, loader: PluginLoader) -> Files:
    return Files(tmp_path, loader)


@pytest.fixture
def simulate() -> Callable[..., Harness]:
    """Makes a `Harness` of a world; plugins may fail."""
    return partial(Harness, allow_failures=True)

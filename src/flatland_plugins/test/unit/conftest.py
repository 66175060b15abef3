"""Shared by the unit tests of the plugins: a folder for worlds, and complete worlds."""

from pathlib import Path
from typing import Any, Callable, Dict, Tuple

import hypothesis
import pytest
from batch_world import write_world

from flatland_server import LocalTransport, PluginLoader, World
from flatland_server.testing import Harness, WorldFiles

pytest.register_assert_rewrite("bumping", "forklift", "readings")

# Equal cases in every run, and no files left behind.
hypothesis.settings.register_profile("flatland", derandomize=True, database=None, deadline=None)
hypothesis.settings.load_profile("flatland")

WORLDS = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds"


@pytest.fixture(scope="session")
def loader() -> PluginLoader:
    """The plugins of this workspace, looked up once."""
    return PluginLoader()


@pytest.fixture
def files(tmp_path: Path, loader: PluginLoader) -> WorldFiles:
    return WorldFiles(tmp_path, loader)


@pytest.fixture
def no_subscribers() -> LocalTransport:
    """A transport without subscribers, until a test adds some."""
    return LocalTransport(subscribed_topics=())


@pytest.fixture
def town(files: WorldFiles) -> Callable[..., Harness]:
    """Makes a world of people, the first one on line 8 of its file."""

    def load(
        *people: str,
        keys: str = "",
        walls: Tuple[str, ...] = (),
        robots: Dict[str, str] = {},  # noqa: B006 (only read)
        **options: Any,
    ) -> Harness:
        layer = f"{{name: map, map: {files.walls('map', *walls)}}}" if walls else "{name: map}"
        lines = [
            "properties: {}",
            f"layers: [{layer}, {{name: other}}]",
            f"models: [{', '.join(f'{{name: {n}, {entry}}}' for n, entry in robots.items())}]",
            "plugins:",
            "  - type: Crowd",
            f"    <<: {{{keys}}}",
            "    pedestrians:" + (" []" if not people else ""),
            *(f"      - {{{person}}}" for person in people),
            "    name: people",
        ]
        return files.load("\n".join(lines), **options)

    return load


@pytest.fixture
def empty_room(loader: PluginLoader) -> Harness:
    """The turtlebot in the middle of an empty room of 10 x 6 m."""
    return Harness(World.from_file(WORLDS / "test_room" / "world.yaml", loader=loader))


@pytest.fixture
def office(loader: PluginLoader) -> Harness:
    """The default world."""
    return Harness(World.from_file(WORLDS / "office" / "world.yaml", loader=loader))


@pytest.fixture(scope="module")
def world_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Writes a world for batches; see `batch_world.write_world`."""
    return lambda *arguments, **more: write_world(
        tmp_path_factory.mktemp("world"), *arguments, **more
    )

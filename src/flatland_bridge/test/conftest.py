"""A world of the bridge's tests, a server and a client of it."""

import pytest
from bridge_clients import ROBOT, WORLD, Client, running


@pytest.fixture
def world(tmp_path):
    """A world file in a folder with a space."""
    folder = tmp_path / "my world"
    folder.mkdir()
    (folder / "robot.model.yaml").write_text(ROBOT)
    (folder / "world.yaml").write_text(WORLD)
    return folder / "world.yaml"


@pytest.fixture
def server(world):
    """A server with a paused simulation."""
    with running(world, is_paused=True) as each:
        yield each


@pytest.fixture
def client(server):
    """A client of rosbridge."""
    each = Client(server)
    yield each
    each.socket.close()

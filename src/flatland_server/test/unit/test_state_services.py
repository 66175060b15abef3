"""Services of time and state that are refused."""

import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.serving.client_files import ClientFiles
from flatland_server.serving.service_host import ServiceHost
from flatland_server.serving.state_services import StateServices
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport


class DirectCalls(ServiceHost):
    """Makes calls for the simulation's thread at once."""

    def __init__(self):
        self.actions = {}

    def offer(self, name, type_name, action):
        self.actions[name] = action

    def call(self, action):
        return action()

    def wait(self, future):
        return future.result()


def test_a_reload_does_not_undo_that_another_world_was_opened_meanwhile(files, monkeypatch):
    """A request for the first world is still reading its file when the second one is there."""
    paths = [files.write(name, "properties: {}\nlayers: []\n") for name in ("a.yaml", "b.yaml")]
    first, second = (WorldConfig.from_file(path) for path in paths)
    host = DirectCalls()
    world = World(first, LocalTransport())
    manager = SimulationManager(world, Timekeeper(0.005))
    StateServices(manager, host, ClientFiles(world, None), 0.1)
    monkeypatch.setattr(world, "read_config", lambda: manager.reload(second) or first)

    with pytest.raises(FlatlandError, match="another world was loaded while the file was read"):
        host.actions["reload_world"](None)

    monkeypatch.undo()
    assert world.read_config().path == paths[1]


def test_a_control_period_between_two_steps_is_refused(files):
    world = World(WorldConfig.from_file(files.write("a.yaml", "properties: {}\nlayers: []\n")))
    manager = SimulationManager(world, Timekeeper(0.03))
    host = DirectCalls()
    StateServices(manager, host, ClientFiles(world, None), 0.1)

    expected = "expected ~control_period to be a multiple of the step_size of 0.03 s, found 0.1 s"
    with pytest.raises(FlatlandError, match=expected):
        host.actions["step_world"](None)

    assert not manager.is_paused

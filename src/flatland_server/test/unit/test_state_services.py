"""Concurrent calls of the services that load worlds."""

import pytest
from std_srvs.srv import TriggerRequest

from flatland_server.exceptions import FlatlandError
from flatland_server.ros.client_files import ClientFiles
from flatland_server.ros.rospy_patches import RospyCalls
from flatland_server.ros.state_services import StateServices
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport


class DirectCalls(LocalTransport):
    """Makes calls for the simulation's thread at once."""

    rospy_calls = RospyCalls()

    def call(self, action):
        return action()


def test_a_reload_does_not_undo_that_another_world_was_opened_meanwhile(files, monkeypatch):
    """A request for the first world is still reading its file when the second one is there."""
    paths = [files.write(name, "properties: {}\nlayers: []\n") for name in ("a.yaml", "b.yaml")]
    first, second = (WorldConfig.from_file(path) for path in paths)
    transport = DirectCalls()
    world = World(first, transport)
    manager = SimulationManager(world, Timekeeper(0.005))
    services = {}
    offer = lambda name, _, __, action: services.update({name: action})  # noqa: E731
    StateServices(manager, transport, ClientFiles(world, None), offer)
    monkeypatch.setattr(world, "read_config", lambda: manager.reload(second) or first)

    with pytest.raises(FlatlandError, match="another world was loaded while the file was read"):
        services["reload_world"](TriggerRequest())

    monkeypatch.undo()
    assert world.read_config().path == paths[1]

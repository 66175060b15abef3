"""Simulation managers on a clock that only the test and waits move."""

from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport


class WaitingTransport(LocalTransport):
    """Waits for its whole timeout on the simulated clock, which is at 1000 s first.

    Attributes:
        waits: the timeouts of all waits [s].
        meanwhile: called in each wait, when its time has passed; may send messages.
    """

    def __init__(self):
        super().__init__()
        self.now = 1000.0
        self.waits = []
        self.meanwhile = lambda: None

    def process(self, timeout=0.0):
        self.waits.append(timeout)
        self.now += timeout
        self.meanwhile()
        super().process(timeout)


def manager_on(transport, files, *arguments, **options):
    """The simulation of an empty world with steps of 5 ms."""
    world = World.from_file(files.write("world.yaml", "{properties: {}, layers: []}"), transport)
    clock = lambda: transport.now  # noqa: E731
    return SimulationManager(world, Timekeeper(0.005), *arguments, clock=clock, **options)


def steps(manager):
    """The number of steps so far."""
    return manager.timekeeper.nanoseconds // 5_000_000

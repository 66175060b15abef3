"""Simulated time that waits for the commands of a controller; on a simulated clock."""

import pytest

from flatland_server.messages import get
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport


class Clocked(LocalTransport):
    """Waits on the simulated clock, and hears a command at some times."""

    def __init__(self):
        super().__init__()
        self.now = 0.0
        self.commands = []  # times [s]

    def process(self, timeout=0.0):
        self.now += timeout
        while self.commands and self.now >= self.commands[0]:
            self.commands.pop(0)
            self.send("/cmd_vel", get("geometry_msgs/Twist")())
        super().process(timeout)


@pytest.fixture
def manager(files):
    """Ten times real time, commands at most 0.1 s of simulated time old."""
    transport = Clocked()
    path = files.write("world.yaml", "properties: {}\nlayers: []\n")
    world = World(WorldConfig.from_file(path), transport)
    transport.subscribe("/cmd_vel", get("geometry_msgs/Twist"), lambda _: None)
    return SimulationManager(
        world, Timekeeper(0.005), 2000.0, command_age=0.1, clock=lambda: transport.now
    )


def run(manager, until, commands=()):
    """Runs up to a real time; returns the simulated time [s] that has passed meanwhile."""
    before, transport = manager.timekeeper.seconds, manager.transport
    transport.commands = list(commands)
    manager.run(lambda: transport.now < until)
    return manager.timekeeper.seconds - before


def test_time_runs_freely_until_the_first_command(manager):
    assert run(manager, 1.0) == pytest.approx(10.0, rel=0.02)


def test_time_stands_still_until_the_next_command(manager):
    passed = run(manager, 1.0, [0.1, 0.3, 0.5, 0.7, 0.9])

    # 1 s before the first command, and 0.1 s after each.
    assert passed == pytest.approx(1.5, abs=0.03)


def test_commands_in_time_slow_nothing_down(manager):
    commands = [0.008 * i for i in range(125)]

    assert run(manager, 1.0, commands) == pytest.approx(10.0, rel=0.02)


def test_a_controller_that_has_ended_is_not_waited_for(manager):
    assert run(manager, 3.0, [1.0]) == pytest.approx(10.0 + 0.1 + 9.9, rel=0.02)
    assert run(manager, 3.5, [3.1]) == pytest.approx(1.0 + 0.1, abs=0.05)


def test_a_pause_is_no_delay_of_the_controller(manager):
    run(manager, 0.5, [0.2])
    manager.pause()
    run(manager, 3.0)
    manager.resume()

    assert run(manager, 3.5) == 0.0

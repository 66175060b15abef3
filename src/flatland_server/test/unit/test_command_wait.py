"""Simulated time that waits for the commands of a controller; on a simulated clock."""

import pytest
from simulated_clock import WaitingTransport, manager_on

from flatland_server.messages import get


@pytest.fixture
def manager(files):
    """Ten times real time, commands at most 0.1 s of simulated time old."""
    transport = WaitingTransport()
    transport.subscribe("/cmd_vel", get("geometry_msgs/Twist"), lambda _: None)
    return manager_on(transport, files, 2000.0, command_age=0.1)


def run(manager, until, commands=()):
    """Runs up to a real time, with commands at some; returns how much simulated time has passed."""
    before, transport, to_come = manager.timekeeper.seconds, manager.transport, list(commands)

    def command():
        while to_come and transport.now >= 1000.0 + to_come[0]:
            to_come.pop(0)
            transport.send("/cmd_vel", get("geometry_msgs/Twist")())

    transport.meanwhile = command
    manager.run(lambda: transport.now < 1000.0 + until)
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

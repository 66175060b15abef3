"""Running a world in real time, pausing it, and callbacks in between; on a simulated clock."""

import math
from functools import partial
from typing import Any, Callable, List

import pytest
from simulated_clock import WaitingTransport, manager_on, steps

from flatland_server.simulation.simulation_manager import SimulationManager


@pytest.fixture
def transport() -> WaitingTransport:
    return WaitingTransport()


@pytest.fixture
def make_manager(files, transport) -> Callable[..., SimulationManager]:
    return partial(manager_on, transport, files)


def rounds(count: int) -> Callable[[], bool]:
    """Ends `run` after this number of rounds."""
    asked = iter(range(count))
    return lambda: next(asked, None) is not None


def test_steps_keep_the_update_rate(make_manager, transport):
    manager = make_manager(100.0)
    manager.after_step.append(lambda: setattr(transport, "now", transport.now + 0.004))

    manager.run(rounds(101))

    assert steps(manager) == 101
    assert transport.now - 1000.0 == pytest.approx(1.01)
    assert transport.waits[1:] == pytest.approx([0.006] * 101)
    assert manager.pacer.step_periods == pytest.approx([0.01] * 100)


def test_an_infinite_rate_never_waits(make_manager, transport):
    manager = make_manager(math.inf)

    manager.run(rounds(100))

    assert steps(manager) == 100
    assert set(transport.waits) == {0.0}


@pytest.mark.parametrize(("rate", "held"), [(200.0, 1), (math.inf, 101)])
def test_messages_are_held_back_only_in_steps_without_a_wait(make_manager, transport, rate, held):
    released = []
    transport.release = lambda: released.append(transport.now)

    make_manager(rate).run(rounds(100))

    assert transport.waits.count(0.0) == held  # the first step is never waited for
    assert len(released) == 1  # at the end


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan])
def test_a_rate_that_is_not_above_zero_is_refused(make_manager, rate):
    with pytest.raises(ValueError, match="expected an update rate above 0 Hz, found "):
        make_manager(rate)


def test_simulated_time_stands_still_during_a_pause(make_manager):
    manager = make_manager()
    pause_twice = lambda: (manager.pause(), manager.pause())  # noqa: E731
    counts = []
    for change in (manager.resume, pause_twice, manager.resume, *[manager.toggle_pause] * 2):
        change()
        manager.run(rounds(3))
        counts.append(steps(manager))

    assert counts == [3, 3, 6, 6, 9]


def test_callbacks_run_during_a_pause(make_manager, transport):
    manager = make_manager()
    received: List[Any] = []

    def resume(message: Any) -> None:
        received.append((message, steps(manager)))
        manager.resume()

    transport.subscribe("resume", str, resume)
    manager.pause()
    manager.run(rounds(5))
    transport.send("resume", "please")
    manager.run(rounds(5))

    assert received == [("please", 0)]
    assert steps(manager) == 5


def test_ticks_go_on_during_a_pause(make_manager):
    manager = make_manager()
    happened: List[str] = []
    manager.after_step.append(lambda: happened.append("step"))
    manager.on_tick.append(lambda: happened.append("tick"))

    manager.run(rounds(2))
    manager.pause()
    manager.run(rounds(3))

    assert happened == ["step", "tick", "step", "tick", "tick", "tick", "tick"]


def test_no_step_follows_a_callback_that_ends_the_run(make_manager, transport):
    manager = make_manager()
    ended: List[Any] = []
    transport.subscribe("end", str, ended.append)
    transport.send("end", "now")

    manager.run(lambda: not ended)

    assert steps(manager) == 0

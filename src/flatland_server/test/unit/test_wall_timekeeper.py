"""Stamps of real time: they follow a clock of the test's own, and nothing else does."""

import math

import numpy as np
import pytest

from flatland_server.exceptions import UsageError
from flatland_server.messages.conversions import set_stamp_offset
from flatland_server.simulation.pacer import WallTimekeeper
from flatland_server.simulation.run import Run
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport

SECOND, STEP = 1_000_000_000, 5_000_000  # ns
START = 1_800_000_000 * SECOND


ROBOT = """
bodies: [{name: base, footprints: [{type: circle, radius: 0.2, density: 1}]}]
plugins:
- {type: Laser, name: laser, body: base, range: 5, noise_std_dev: 0.1, angle: ANGLES}
""".replace("ANGLES", "{min: -1, max: 1, increment: 0.5}")
WORLD = """
properties: {}
layers: [{name: walls, map: {segments: [[2, -5, 2, 5]]}}]
models: [{name: robot, model: robot.model.yaml}]
"""


class Clock:
    """Real time that only the test and waits move."""

    def __init__(self):
        self.now = START

    def nanoseconds(self):
        return self.now

    def seconds(self):
        return (self.now - START) * 1e-9


class WaitingTransport(LocalTransport):
    """Waits for its whole timeout on the clock, and once for a `delay` [ns]."""

    def __init__(self, clock):
        super().__init__()
        self.delay = 0
        self._clock = clock

    def process(self, timeout=0.0):
        self._clock.now += math.ceil(timeout * 1e9) + self.delay
        self.delay = 0
        super().process(timeout)


@pytest.fixture
def clock():
    yield Clock()
    set_stamp_offset(0)


@pytest.fixture
def world(files):
    """A robot with noise in its scans, in a world on a transport."""
    files.write("robot.model.yaml", ROBOT)
    path = files.write("world.yaml", WORLD)
    return lambda transport: World.from_file(path, transport)


@pytest.fixture
def manager(world, clock):
    transport = WaitingTransport(clock)
    timekeeper = WallTimekeeper(0.005, clock.nanoseconds)
    return SimulationManager(world(transport), timekeeper, clock=clock.seconds)


@pytest.fixture
def stamps(manager, clock):
    """The stamps of all scans, and what the real time was then [ns]."""
    found = []
    manager.after_step.append(
        lambda: found.append((manager.transport.last("/scan").header.stamp.to_nsec(), clock.now))
    )
    return found


def run(manager, steps):
    end = manager.timekeeper.nanoseconds + steps * STEP
    manager.run(lambda: manager.timekeeper.nanoseconds < end)


def run_in_pause(manager, rounds):
    asked = iter(range(rounds))
    manager.run(lambda: next(asked, None) is not None)


def test_stamps_are_a_step_apart_though_steps_are_late(manager, stamps):
    run(manager, 50)
    manager.transport.delay = SECOND // 5  # which the pacer catches up
    run(manager, 100)

    assert set(np.diff([stamp for stamp, _ in stamps])) == {STEP}
    assert stamps[-1][0] == pytest.approx(stamps[-1][1], abs=STEP)


def test_a_pause_is_a_jump_of_the_stamps_and_of_nothing_else(manager, clock, stamps):
    run(manager, 10)
    manager.pause()
    clock.now += 60 * SECOND
    run_in_pause(manager, 2)
    manager.resume()
    run(manager, 10)

    before, after = stamps[9], stamps[10]
    assert manager.timekeeper.nanoseconds == len(stamps) * STEP
    assert after[0] - before[0] == pytest.approx(60 * SECOND, abs=SECOND / 10)
    assert all(abs(stamp - real) < 2 * STEP for stamp, real in stamps[10:])


def test_stamps_make_up_for_time_that_the_pacer_gives_up(manager, stamps):
    """The process was stopped for a second: a quarter of it is caught up by steps without waits."""
    run(manager, 10)
    manager.pacer.start = lambda _: None  # the next run goes on with this one
    manager.transport.delay = SECOND
    run(manager, 200)

    assert all(stamp <= real for stamp, real in stamps)
    assert stamps[-1][0] == pytest.approx(stamps[-1][1], abs=STEP)
    assert (np.diff([stamp for stamp, _ in stamps]) > 0).all()


@pytest.mark.parametrize("jump", ["reset", "load_state", "seek"])
def test_stamps_go_on_where_simulated_time_goes_back(manager, clock, stamps, jump):
    if jump == "seek":
        manager.keep_history()
    state = manager.save_state()
    run(manager, 100)

    {
        "reset": manager.reset,
        "load_state": lambda: manager.load_state(state),
        "seek": lambda: manager.seek(0.2),
    }[jump]()
    begin = manager.timekeeper.nanoseconds
    run(manager, 10)

    assert begin in (0, 200_000_000)
    assert manager.timekeeper.nanoseconds == begin + 10 * STEP
    assert (np.diff([stamp for stamp, _ in stamps]) >= STEP).all()
    assert stamps[-1][0] == pytest.approx(stamps[-1][1], abs=3 * STEP)


def test_stamps_never_go_back_after_requested_steps(manager, stamps):
    manager.pause()
    for count in (1000, 1):
        manager.request_steps(count)
        run_in_pause(manager, count)

    found = [stamp for stamp, _ in stamps]
    assert set(np.diff(found)) == {STEP}
    assert found[0] == START


def test_a_real_clock_that_is_set_back_leaves_the_stamps_alone(manager, clock, stamps):
    run(manager, 10)
    manager.timekeeper._clock = lambda: clock.now - 3600 * SECOND
    run(manager, 10)

    assert set(np.diff([stamp for stamp, _ in stamps])) == {STEP}


@pytest.mark.parametrize("rate", [2.0, 0.5, float("inf")])
def test_other_rates_than_real_time_are_refused(manager, world, clock, rate):
    with pytest.raises(UsageError, match=f"expected a rate of 1, .* found {rate:g}"):
        manager.change_rate(rate)
    with pytest.raises(UsageError, match="expected a rate of 1"):
        SimulationManager(world(LocalTransport()), WallTimekeeper(0.005), rate * 200.0)

    manager.change_rate(1.0)
    assert manager.rate == 1.0


def test_a_run_is_the_same_but_for_its_stamps(world, clock):
    def scans(timekeeper):
        run = Run(world(LocalTransport()), timekeeper)
        found = []
        for _ in range(20):
            run.step()
            found.append(run.transport.last("/scan"))
        return run.save_state(), found

    state, plain = scans(Timekeeper(0.005))
    same_state, stamped = scans(WallTimekeeper(0.005, clock.nanoseconds))

    assert same_state == state
    for one, other in zip(plain, stamped):
        assert (one.ranges == other.ranges).all()
        assert other.header.stamp.to_nsec() == START + one.header.stamp.to_nsec()

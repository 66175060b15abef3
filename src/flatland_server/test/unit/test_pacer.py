"""The schedule of steps and ticks, on a clock that only the test moves."""

import math
from typing import List

import pytest

from flatland_server.simulation.pacer import Pacer

PERIOD = 0.01
MAX_WAIT = 0.02  # s; ticks are no further apart, whatever the period
MAX_BACKLOG = 0.25  # s


class Loop:
    """A simulation's loop around a pacer: each wait and each step takes time on a clock."""

    def __init__(self) -> None:
        self.now = 1000.0
        self.pacer = Pacer(lambda: self.now)
        self.step_duration = 0.0
        self.tick_duration = 0.0
        self.is_paused = False
        self.simulated_time = 0.0
        self.waits: List[float] = []
        self.steps: List[float] = []
        """Times at which steps have begun, since the start [s]."""
        self.ticks: List[float] = []
        self.pacer.start(self.simulated_time)

    def run(self, rounds: int, period: float = PERIOD) -> None:
        for _ in range(rounds):
            self.waits.append(self.pacer.wait_time)
            self.now += self.waits[-1]
            if self.pacer.begin_step(self.is_paused):
                self.steps.append(self.now - 1000.0)
                self.now += self.step_duration
                self.simulated_time += PERIOD
            if self.pacer.end_step(period, self.is_paused):
                self.ticks.append(self.now - 1000.0)
                self.now += self.tick_duration
                self.pacer.end_tick(self.simulated_time)

    def run_slow_step(self, duration: float) -> None:
        """Runs one round with a step of this duration [s]."""
        usual, self.step_duration = self.step_duration, duration
        self.run(1)
        self.step_duration = usual


@pytest.fixture
def loop() -> Loop:
    return Loop()


def test_the_first_step_is_due_at_once_then_one_each_period(loop):
    loop.run(4)

    assert loop.steps == pytest.approx([0.0, 0.01, 0.02, 0.03])


def test_durations_of_steps_and_ticks_do_not_accumulate(loop):
    loop.step_duration, loop.tick_duration = 0.003, 0.002

    loop.run(4)

    assert loop.steps == pytest.approx([0.0, 0.01, 0.02, 0.03])
    assert loop.waits == pytest.approx([0.0, 0.005, 0.005, 0.005])


def test_no_step_is_due_before_its_time(loop):
    loop.run(1)

    loop.now += 0.004  # the wait has ended early, as with a message
    assert not loop.pacer.begin_step(is_paused=False)
    loop.pacer.end_step(PERIOD, is_paused=False)

    assert loop.pacer.wait_time == pytest.approx(0.006)


def test_a_long_wait_is_divided_by_ticks(loop):
    loop.run(5, period=0.05)

    assert loop.waits == pytest.approx([0.0, MAX_WAIT, MAX_WAIT, 0.01, MAX_WAIT])
    assert loop.steps == pytest.approx([0.0, 0.05])
    assert len(loop.ticks) == 5


def test_a_short_delay_is_caught_up(loop):
    loop.run_slow_step(0.045)

    loop.run(6)

    assert loop.steps == pytest.approx([0.0, 0.045, 0.045, 0.045, 0.045, 0.05, 0.06])


def test_a_long_delay_is_caught_up_in_part(loop):
    loop.run_slow_step(3600.0)

    loop.run(100)

    late = round(MAX_BACKLOG / PERIOD)
    assert loop.waits[1 : late + 1] == [0.0] * late
    assert loop.waits[late + 2 :] == pytest.approx([PERIOD] * (99 - late), abs=1e-6)


def test_another_period_takes_effect_at_once(loop):
    loop.run(1, period=10.0)

    loop.run(2, period=0.015)

    assert loop.steps == pytest.approx([0.0, 0.02])  # after the wait that had begun
    assert loop.waits == pytest.approx([0.0, MAX_WAIT, 0.0])


def test_no_step_is_due_during_a_pause_but_ticks_are(loop):
    loop.is_paused = True

    loop.run(5)

    assert loop.steps == []
    assert loop.ticks == pytest.approx([0.0, 0.02, 0.04, 0.06, 0.08])


@pytest.mark.parametrize("period", [0.0, 1.0 / math.inf, 1e-6])
def test_a_pause_waits_even_if_steps_do_not(loop, period):
    loop.is_paused = True

    loop.run(5, period)

    assert loop.waits == pytest.approx([0.0, *[MAX_WAIT] * 4])


def test_after_a_pause_nothing_is_caught_up(loop):
    loop.run(2)
    loop.is_paused = True
    loop.run(50)
    loop.is_paused = False
    loop.steps.clear()

    loop.run(4)

    first = loop.steps[0]
    assert loop.steps == pytest.approx([first + i * PERIOD for i in range(4)])


def test_ticks_without_waits_are_a_millisecond_apart(loop):
    loop.step_duration = 0.0004

    loop.run(7, period=0.0)

    assert loop.waits == [0.0] * 7
    assert loop.ticks == pytest.approx([0.0004, 0.0016, 0.0028])


def test_a_tick_comes_before_every_wait_however_short(loop):
    loop.run(5, period=0.0001)

    assert loop.ticks == pytest.approx([0.0, 0.0001, 0.0002, 0.0003, 0.0004])


def test_step_periods_tell_late_steps_from_punctual_ones(loop):
    loop.run(2)
    loop.run_slow_step(0.015)
    loop.run(3)

    assert loop.pacer.step_periods == pytest.approx([0.01, 0.01, 0.015, 0.005, 0.01])


def test_step_periods_are_forgotten_in_a_pause(loop):
    loop.run(3)
    loop.is_paused = True
    loop.run(3)
    assert loop.pacer.step_periods == []

    loop.is_paused = False
    loop.run(3)

    assert loop.pacer.step_periods == pytest.approx([0.01, 0.01])


def test_no_more_than_the_latest_thousand_step_periods_are_kept(loop):
    loop.run(1500)

    assert len(loop.pacer.step_periods) == 1000


@pytest.mark.parametrize(("period", "factor"), [(0.01, 1.0), (0.02, 0.5), (0.005, 2.0)])
def test_the_real_time_factor_is_simulated_time_per_real_time(loop, period, factor):
    loop.run(round(3.0 / period), period)

    assert loop.pacer.real_time_factor == pytest.approx(factor, rel=0.03)


def test_the_real_time_factor_is_measured_anew_every_second(loop):
    loop.run(110)
    assert loop.pacer.real_time_factor == pytest.approx(1.0, rel=0.03)

    loop.is_paused = True
    loop.run(110)

    assert loop.pacer.real_time_factor == 0.0

"""Simulated time is exact to the nanosecond; updates at lower rates do not drift."""

import math
from typing import List

import numpy as np
import pytest

from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer, due_after


def update_times(rate: float, seconds: float, step_size: float = 0.005) -> List[int]:
    """The times [ns] at which an update was due, checked at each step."""
    timekeeper, timer = Timekeeper(step_size), UpdateTimer(rate)
    times = []
    for _ in range(round(seconds / step_size)):
        if timer.check_update(timekeeper):
            times.append(timekeeper.nanoseconds)
        timekeeper.step()
    return times


@pytest.mark.parametrize("rate", [1e10, 33.3, 30.0, 7.0, 0.3, 1e-320])
def test_updates_of_many_environments_are_due_as_those_of_one(rate):
    times, timer = np.arange(0, 10**9, 5_000_000), UpdateTimer(rate)
    expected = []
    for now in times.tolist():
        timer.due = 0
        timer.check_update_at(now)
        expected.append(timer.due)

    assert due_after(times, rate).tolist() == expected


def gaps(times: List[int]) -> List[int]:
    return [later - earlier for earlier, later in zip(times, times[1:])]


def test_time_does_not_drift_in_a_million_steps():
    timekeeper = Timekeeper(0.1)  # in binary, 0.1 is not a tenth

    for _ in range(1_000_000):
        timekeeper.step()

    assert timekeeper.nanoseconds == 100_000 * 10**9
    assert timekeeper.seconds == 100_000.0


def test_a_step_is_rounded_to_a_nanosecond():
    timekeeper = Timekeeper(2 / 3)

    timekeeper.step()

    assert timekeeper.nanoseconds == 666_666_667
    assert timekeeper.step_size == pytest.approx(0.666666667, abs=1e-15)


@pytest.mark.parametrize("step_size", [0.0, -0.005, 1e-10, 1000.1, 1e9, math.nan, math.inf])
def test_an_invalid_step_size_is_refused(step_size):
    with pytest.raises(ValueError, match=r"expected a step of 1e-9 to 1000 s, found "):
        Timekeeper(step_size)


def test_30_hz_at_steps_of_5_ms_is_kept_on_average():
    times = update_times(30.0, 100.0)

    assert abs(len(times) - 3000) <= 1
    assert set(gaps(times)) == {30_000_000, 35_000_000}
    # Never early, and never late by a whole step.
    assert all(0 <= time - i * 1e9 / 30 < 5_000_000 for i, time in enumerate(times))


@pytest.mark.parametrize(
    ("rate", "period"),
    [
        (10.0, 100_000_000),
        *((rate, 5_000_000) for rate in (200.0, 1000.0, math.inf)),  # every step
        *((rate, 10**10) for rate in (1e-9, 1e-300)),  # once
    ],
)
def test_updates_are_due_at_the_rate_or_at_every_step(rate, period):
    assert update_times(rate, 10.0) == list(range(0, 10**10, period))


def test_a_rate_that_does_not_divide_the_step_rate_has_no_drift():
    times = update_times(7.0, 1000.0)

    assert len(times) == 7000
    assert times[-1] == pytest.approx(6999 / 7 * 1e9, abs=5e6)


def test_the_first_check_is_due_at_any_time():
    timekeeper, timer = Timekeeper(0.005), UpdateTimer(10.0)
    for _ in range(7):
        timekeeper.step()

    assert timer.check_update(timekeeper)
    assert not timer.check_update(timekeeper)


def test_missed_updates_are_not_caught_up():
    timekeeper, timer = Timekeeper(0.005), UpdateTimer(10.0)
    timer.check_update(timekeeper)
    for _ in range(71):  # 355 ms
        timekeeper.step()

    assert timer.check_update(timekeeper)
    assert not timer.check_update(timekeeper)
    for _ in range(9):  # 400 ms
        timekeeper.step()
    assert timer.check_update(timekeeper)


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, -math.inf])
def test_an_invalid_rate_is_refused(rate):
    with pytest.raises(ValueError, match=r"expected a rate above 0 Hz, found "):
        UpdateTimer(rate)


@pytest.mark.parametrize(("rate", "period"), [(10.0, 0.1), (math.inf, 0.0)])
def test_the_period_is_one_over_the_rate(rate, period):
    assert UpdateTimer(rate).period == pytest.approx(period)

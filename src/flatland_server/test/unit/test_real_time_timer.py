"""Rates of real time, on a clock that is put forward."""

import pytest

from flatland_server.ros import real_time_timer
from flatland_server.ros.real_time_timer import RealTimeTimer


class Clock:
    """Stands in for `time`."""

    now = 1000.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(real_time_timer, "time", clock)
    return clock


def test_it_is_due_at_once_and_then_once_a_period(clock: Clock) -> None:
    timer = RealTimeTimer(1.0)

    due = []
    for _ in range(9):
        due.append(timer.check_update())
        clock.now += 0.25

    assert due == [True, False, False, False, True, False, False, False, True]


def test_who_asks_a_bit_late_each_time_is_told_as_often(clock: Clock) -> None:
    timer = RealTimeTimer(1.0)
    assert timer.check_update()

    told = 0
    for _ in range(100):
        clock.now += 0.375
        told += timer.check_update()

    assert told == 37


def test_what_was_missed_is_not_made_up_for(clock: Clock) -> None:
    timer = RealTimeTimer(1.0)
    assert timer.check_update()

    clock.now += 5.5

    assert timer.check_update()
    assert not timer.check_update()
    clock.now += 1.0
    assert timer.check_update()

"""Periods of real time, with a fake clock."""

import pytest

from flatland_server import real_time_timer
from flatland_server.real_time_timer import RealTimeTimer


class Clock:
    """A fake of the module `time`."""

    now = 1000.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(real_time_timer, "time", clock)
    return clock


def test_a_timer_is_due_at_once_and_then_once_a_period(clock: Clock) -> None:
    timer = RealTimeTimer(1.0)

    due = []
    for _ in range(9):
        due.append(timer.check_update())
        clock.now += 0.25

    assert due == [True, False, False, False, True, False, False, False, True]


def test_late_checks_do_not_lower_the_rate(clock: Clock) -> None:
    timer = RealTimeTimer(1.0)
    assert timer.check_update()

    count = 0
    for _ in range(100):
        clock.now += 0.375
        count += timer.check_update()

    assert count == 37


def test_missed_periods_are_skipped(clock: Clock) -> None:
    timer = RealTimeTimer(1.0)
    assert timer.check_update()

    clock.now += 5.5

    assert timer.check_update()
    assert not timer.check_update()
    clock.now += 1.0
    assert timer.check_update()

"""The number of steps in a frame of the window."""

import pytest

from flatland2d.viewer.playback import RATES, Playback

STEP = 0.005


@pytest.fixture
def made():
    return []


def advance(playback, made, elapsed, limit=10**9):
    """Advances, and returns the number of steps that were made."""
    before = len(made)
    playback.advance(elapsed, STEP, lambda: made.append(1), lambda: len(made) - before >= limit)
    return len(made) - before


@pytest.mark.parametrize(("rate", "steps"), [(1.0, 200), (0.1, 20), (5.0, 1000)])
def test_simulated_time_passes_at_the_rate(made, rate, steps):
    playback = Playback(rate)

    for _ in range(30):
        advance(playback, made, 1 / 30)

    assert len(made) == pytest.approx(steps, abs=1)
    assert playback.measured_rate == pytest.approx(rate, rel=0.1)


def test_steps_that_cannot_be_made_in_time_are_left_out(made):
    playback = Playback(100.0)

    assert advance(playback, made, 0.02, limit=7) == 7
    assert advance(playback, made, 0.0) == 0


def test_a_long_frame_is_not_caught_up(made):
    assert advance(Playback(), made, 60.0) == 50


def test_nothing_passes_during_a_pause_or_after_it(made):
    playback = Playback()
    playback.is_paused = True
    assert advance(playback, made, 0.2) == 0

    playback.is_paused = False
    assert advance(playback, made, 0.01) == 2


def test_a_pause_has_a_rate_of_zero(made):
    playback = Playback()
    for is_paused in (False, True):
        playback.is_paused = is_paused
        for _ in range(10):
            advance(playback, made, 0.1)

    assert playback.measured_rate == 0.0


def test_rates_go_up_and_down_and_stay_within_their_limits():
    playback = Playback(3.0)

    playback.faster()
    assert playback.rate == 5.0
    playback.slower()
    playback.slower()
    assert playback.rate == 1.0
    for _ in RATES:
        playback.slower()
    assert playback.rate == RATES[0]
    for _ in range(20):
        playback.faster()
    assert playback.rate == RATES[-1]

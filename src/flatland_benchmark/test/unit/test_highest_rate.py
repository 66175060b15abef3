"""The search for the highest rate with every message."""

import math

import pytest

from flatland_benchmark.highest_rate import highest_rate


@pytest.mark.parametrize("limit", [1.2, 37.0, 900.0])
def test_the_highest_rate_is_within_5_percent_of_the_limit(limit):
    asked = []

    def reached(rate):
        asked.append(rate)
        return rate if rate <= limit else None

    assert limit / 1.05 <= highest_rate(reached) <= limit
    assert len(asked) < 16


def test_a_rate_that_the_simulation_does_not_reach_is_too_high():
    assert highest_rate(lambda rate: None if math.isinf(rate) else min(rate, 50.0)) == (
        pytest.approx(50.0, rel=0.05)
    )


def test_without_losses_the_rate_is_that_of_the_simulation():
    assert highest_rate(lambda rate: min(rate, 500.0)) == 500.0


def test_the_highest_rate_is_0_if_messages_are_lost_in_real_time():
    assert highest_rate(lambda rate: None) == 0.0

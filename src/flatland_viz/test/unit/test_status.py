"""The contents of the status line."""

import math

import pytest

from flatland_viz.status import Simulation, has_restarted, status

RUNNING = Simulation(time=12.345, is_paused=False, rate=1.0, real_time_factor=0.999)


@pytest.mark.parametrize(
    ("rate", "factor", "speed"),
    [
        (1.0, 0.91, "0.91 x"),
        (1.0, 0.5, "0.50 of 1 x"),
        (10.0, 4.321, "4.32 of 10 x"),
        (0.1, 0.1, "0.10 x"),
        (math.inf, 87.6, "87.60 x"),
    ],
)
def test_the_requested_speed_is_shown_if_it_is_not_reached(rate, factor, speed):
    simulation = RUNNING._replace(rate=rate, real_time_factor=factor)

    assert status(simulation, silence=0.0).speed == speed


@pytest.mark.parametrize(
    ("simulation", "silence", "shown"),
    [
        (RUNNING, 1.9, ("12.3 s", "1.00 x", "running")),
        (RUNNING._replace(is_paused=True, real_time_factor=0.0), 0.2, ("12.345 s", "", "paused")),
        (RUNNING, 2.1, ("12.3 s", "", "no server")),
        (None, 100.0, ("", "", "waiting for the server")),
    ],
)
def test_the_line_has_time_speed_and_state(simulation, silence, shown):
    assert status(simulation, silence) == shown


@pytest.mark.parametrize(
    ("before", "silence", "time", "is_other_run"),
    [
        pytest.param(None, 0.1, 0.0, False, id="the first message"),
        pytest.param(RUNNING, 0.2, 12.5, False, id="it continues"),
        pytest.param(RUNNING, 0.2, 12.345, False, id="paused"),
        pytest.param(RUNNING, 0.2, 0.1, True, id="time went back"),
        pytest.param(RUNNING, 2.5, 50.0, True, id="after silence"),
    ],
)
def test_another_run_is_noticed(before, silence, time, is_other_run):
    assert has_restarted(before, silence, RUNNING._replace(time=time)) is is_other_run

"""The status line: what it says of the simulation."""

import math
from typing import NamedTuple, Optional

SILENCE = 2.0
"""Seconds of real time without a word from the server, after which it is taken to be gone."""


class Simulation(NamedTuple):
    """How the simulation goes, as the server last told."""

    time: float
    """Simulated [s]."""
    is_paused: bool
    rate: float
    """Asked for: simulated seconds per second of real time; may be infinite."""
    real_time_factor: float
    """Reached."""


class Status(NamedTuple):
    """The three fields of the line."""

    time: str
    speed: str
    state: str


def is_gone(silence: float) -> bool:
    """Whether a server is gone that has not been heard for so long [s of real time]."""
    return silence > SILENCE


def status(simulation: Optional[Simulation], silence: float) -> Status:
    """What the line says.

    Args:
        simulation: what the server told last; None if it has never been heard.
        silence: how long ago that was [s of real time].
    """
    if simulation is None:
        return Status("", "", "waiting for the server")
    time = f"{simulation.time:.1f} s"
    if is_gone(silence):
        return Status(time, "", "no server")
    if simulation.is_paused:
        return Status(time, "", "paused")
    return Status(time, speed(simulation), "running")


def speed(simulation: Simulation) -> str:
    """How fast it goes; and how fast it should, where it is more than a tenth slower."""
    factor, rate = simulation.real_time_factor, simulation.rate
    reached = f"{factor:.2f} x real time"
    lags = math.isfinite(rate) and factor < 0.9 * rate
    return f"{reached} (asked: {rate:g} x)" if lags else reached


def has_restarted(before: Optional[Simulation], silence: float, now: Simulation) -> bool:
    """Whether this is another run than before: it comes after silence, or time went back."""
    return before is not None and (is_gone(silence) or now.time < before.time)

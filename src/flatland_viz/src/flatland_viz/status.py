"""The contents of the status line."""

import math
from typing import NamedTuple, Optional

SILENCE = 2.0
"""Seconds of real time without a message after which the server is taken to be gone."""


class Simulation(NamedTuple):
    """The simulation's state in the server's last message."""

    time: float
    """Simulated time [s]."""
    is_paused: bool
    rate: float
    """Requested rate: simulated seconds per second of real time; may be infinite."""
    real_time_factor: float
    """Simulated seconds per second of real time, as measured."""
    begin: float = 0.0
    """The first time that the server can go back to [s]."""
    end: float = 0.0
    """The last one [s]; equal to `begin` if there are none."""
    edits: int = 0
    """The number of models that differ from the world's file, by changes of clients."""
    undo: str = ""
    """The edit that would be undone; empty if there is none."""
    redo: str = ""
    """The edit that would be done again."""


class Status(NamedTuple):
    """The three fields of the line."""

    time: str
    speed: str
    state: str


def is_gone(silence: float) -> bool:
    """True if the server counts as gone after a silence [s of real time]."""
    return silence > SILENCE


def status(simulation: Optional[Simulation], silence: float) -> Status:
    """The fields of the line. Paused, the time has milliseconds, in which steps are counted.

    Args:
        simulation: the last state; None if there has been none.
        silence: its age [s of real time].
    """
    if simulation is None:
        return Status("", "", "waiting for the server")
    time = f"{simulation.time:.{3 if simulation.is_paused else 1}f} s"
    if is_gone(silence):
        return Status(time, "", "no server")
    if simulation.is_paused:
        return Status(time, "", "paused")
    return Status(time, speed(simulation), "running")


def speed(simulation: Simulation) -> str:
    """The measured rate, and the requested one if the former is slower by more than a tenth."""
    factor, rate = simulation.real_time_factor, simulation.rate
    lags = math.isfinite(rate) and factor < 0.9 * rate
    return f"{factor:.2f} of {rate:g} x" if lags else f"{factor:.2f} x"


def has_restarted(before: Optional[Simulation], silence: float, now: Simulation) -> bool:
    """True if the server was restarted: after a silence, or because time went back."""
    return before is not None and (is_gone(silence) or now.time < before.time)

"""Drives a robot by the keys that are held down."""

import inspect
import math
from typing import Optional, Sequence, Set, Tuple

from flatland2d.simulation import Simulation
from flatland_teleop.driving_keys import SLOW, Direction

SPEED = 0.5
"""The speed of a robot [m/s]."""

TURN = 1.0
"""The yaw rate [rad/s], or a tricycle's steering angle [rad]."""

_UNKNOWN = (math.nan,) * 3
"""A command that differs from each other one."""


class KeyboardDrive:
    """Commands a robot's drive, whenever keys are pressed or released.

    Args:
        simulation: has the robot.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._commanded: Tuple[str, Tuple[float, ...]] = ("", ())
        self._driven: Set[str] = set()

    def command(self, model: str, direction: Direction, *, is_slow: bool = False) -> None:
        """Commands a model, if it is another one than before, or the keys have changed.

        Args:
            model: its name; one that has no drive is not commanded.
            direction: of the keys that are held.
            is_slow: whether to drive half as fast.
        """
        factor = SLOW if is_slow else 1.0
        speed, turn = factor * SPEED, factor * TURN
        wanted = (speed * direction.forwards, speed * direction.left, turn * direction.turn)
        former, values = self._commanded
        if former != model and any(values):
            self._send(former, (0.0, 0.0, 0.0))
        if (former, values) != (model, wanted) and (any(values) or any(wanted)):
            self._send(model, wanted)
        self._commanded = (model, wanted)

    def forget(self) -> None:
        """Must be called after a reset: robots have no commands any more."""
        self._commanded = ("", ())

    def time_has_jumped(self) -> None:
        """Must be called after a jump in time: a robot may have any former command of the keys."""
        model, _ = self._commanded
        self._commanded = (model, _UNKNOWN if model in self._driven else ())

    def _send(self, model: str, wanted: Sequence[float]) -> None:
        self._driven.add(model)
        drive = first_drive(self._simulation, model)
        if drive is None:
            return
        parameters = inspect.signature(
            self._simulation.models[model].plugin(drive).command
        ).parameters
        # Drives take vx and omega, or vx, vy and omega; a tricycle a speed and an angle.
        values = wanted if len(parameters) == 3 else (wanted[0], wanted[2])
        self._simulation.models[model].drives[drive].command(*values)


def first_drive(simulation: Simulation, model: str) -> Optional[str]:
    """The name of a model's first drive; None if it has none, or is not there."""
    handle = simulation.models.get(model)
    return next(iter(handle.drives), None) if handle is not None else None

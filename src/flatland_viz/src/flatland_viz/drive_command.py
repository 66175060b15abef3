"""Commands of the Drive panel's keys and pad."""

from typing import AbstractSet, Dict, NamedTuple, Tuple

from python_qt_binding.QtCore import Qt

from flatland_teleop.driving_keys import DIRECTIONS, Direction, direction


class Speeds(NamedTuple):
    """The greatest speeds."""

    linear: float
    """Greatest speed [m/s]."""
    turn: float
    """Greatest yaw rate [rad/s], or the steering angle of a tricycle [rad]."""


Command = Direction
STOP = Command()
KEYS: Dict[int, str] = {getattr(Qt, f"Key_{key.capitalize()}"): key for key in DIRECTIONS}
"""The name of each of Qt's keys that drive."""


def of_keys(held: AbstractSet[int]) -> Command:
    """The command of keys that are held down together."""
    return direction(KEYS[key] for key in held)


def of_pad(right: float, up: float) -> Command:
    """The command of a point on the pad: up is forwards, right is clockwise; each from -1 to 1."""
    return Command(forwards=up, turn=-right)


def velocity(command: Command, speeds: Speeds, factor: float = 1.0) -> Tuple[float, float, float]:
    """The velocities along x and y [m/s] and about z [rad/s] of a geometry_msgs/Twist."""
    return (
        factor * speeds.linear * command.forwards,
        factor * speeds.linear * command.left,
        factor * speeds.turn * command.turn,
    )

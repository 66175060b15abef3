"""Commands of the Drive panel's keys and pad."""

from typing import AbstractSet, Dict, NamedTuple, Tuple

from python_qt_binding.QtCore import Qt


class Command(NamedTuple):
    """A direction to drive in, as parts of the greatest speeds: each from -1 to 1."""

    forwards: float = 0.0
    left: float = 0.0
    turn: float = 0.0
    """Positive counter-clockwise."""


class Speeds(NamedTuple):
    """The greatest speeds."""

    linear: float
    """Greatest speed [m/s]."""
    turn: float
    """Greatest yaw rate [rad/s], or the steering angle of a tricycle [rad]."""


STOP = Command()
SLOW = 0.5
"""Factor of the speeds while Shift is held."""

KEYS: Dict[int, Command] = {
    Qt.Key_Up: Command(forwards=1.0),
    Qt.Key_Down: Command(forwards=-1.0),
    Qt.Key_Left: Command(turn=1.0),
    Qt.Key_Right: Command(turn=-1.0),
    Qt.Key_W: Command(forwards=1.0),
    Qt.Key_S: Command(forwards=-1.0),
    Qt.Key_A: Command(turn=1.0),
    Qt.Key_D: Command(turn=-1.0),
    Qt.Key_Q: Command(left=1.0),
    Qt.Key_E: Command(left=-1.0),
}
"""The command of each key."""


def of_keys(held: AbstractSet[int]) -> Command:
    """The command of keys that are held down together; opposite ones cancel each other."""
    commands = [KEYS[key] for key in held]
    return Command(*(max(-1.0, min(1.0, sum(part))) for part in zip(STOP, *commands)))


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

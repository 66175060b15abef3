"""The keys that drive robots: the same in the window, in terminals, and in the page's driving.js.

Keys have the names "up", "down", "left", "right" (arrows), and small letters.
"""

from typing import Dict, Iterable, NamedTuple, Tuple


class Direction(NamedTuple):
    """A direction to drive in, in parts of the speed: each from -1 to 1 (REP 103)."""

    forwards: float = 0.0
    left: float = 0.0
    turn: float = 0.0
    """Positive counter-clockwise."""


class Command(NamedTuple):
    """Speeds in the robot's frame (REP 103)."""

    x: float = 0.0
    """Forwards [m/s]."""
    y: float = 0.0
    """To the left [m/s]."""
    yaw: float = 0.0
    """Counter-clockwise [rad/s], or the steering angle of a tricycle [rad]."""


DIRECTIONS: Dict[str, Direction] = {
    **dict.fromkeys(("up", "w"), Direction(forwards=1.0)),
    **dict.fromkeys(("down", "s"), Direction(forwards=-1.0)),
    **dict.fromkeys(("left", "a"), Direction(turn=1.0)),
    **dict.fromkeys(("right", "d"), Direction(turn=-1.0)),
    "q": Direction(left=1.0),
    "e": Direction(left=-1.0),
}
"""The direction of each key."""

SLOW = 0.5
"""Factor of the speeds while Shift is held."""

HELP: Tuple[Tuple[str, str], ...] = (
    ("arrows, W A S D", "drive and turn"),
    ("Q, E", "drive sideways, if the drive can"),
    ("Shift", "half as fast"),
)
"""Keys, and what they do."""


def direction(held: Iterable[str]) -> Direction:
    """The direction of keys that are held together; opposite ones cancel each other."""
    parts = zip(Direction(), *(DIRECTIONS[key] for key in held))
    return Direction(*(max(-1.0, min(1.0, sum(part))) for part in parts))


def command(held: Iterable[str], speed: float, turn: float, is_slow: bool) -> Command:
    """The command of keys that are held together.

    Args:
        held: names of the keys.
        speed: [m/s].
        turn: [rad/s], or the steering angle of a tricycle [rad].
        is_slow: whether Shift is held.
    """
    forwards, left, yaw = direction(held)
    factor = SLOW if is_slow else 1.0
    return Command(factor * speed * forwards, factor * speed * left, factor * turn * yaw)

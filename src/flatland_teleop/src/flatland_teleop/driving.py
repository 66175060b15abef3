"""Commands from keys: directions while keys are held, and changes of speed. Independent of ROS."""

from typing import Dict

from flatland_teleop.driving_keys import DIRECTIONS, Command, command
from flatland_teleop.keys import KeyEvent

STOPS = (" ", "focus_out")
_FACTORS = {
    "+": (1.1, 1.1),
    "=": (1.1, 1.1),
    "-": (1 / 1.1, 1 / 1.1),
    ".": (1, 1.1),
    ",": (1, 1 / 1.1),
}
"""Factors of a key for the speed and the turning speed."""


class Driving:
    """The command of the keys that are held.

    A terminal sends a held key again and again: at once, after its delay for repeating (250 to
    660 ms), and then some 30 times a second. So a key counts as released after `first_timeout`
    if it came once, and after `repeat_timeout` once it repeats. Where the terminal sends
    releases, they count instead.

    Args:
        speed: [m/s].
        turn: [rad/s].
        first_timeout: [s].
        repeat_timeout: [s].
    """

    def __init__(
        self,
        speed: float = 0.5,
        turn: float = 1.0,
        first_timeout: float = 0.7,
        repeat_timeout: float = 0.2,
    ) -> None:
        self.speed = speed
        self.turn = turn
        self._first_timeout = first_timeout
        self._repeat_timeout = repeat_timeout
        self._held: Dict[str, float] = {}  # time until which each key counts as held
        self._is_slow = False

    def on_key(self, event: KeyEvent, now: float) -> None:
        """Takes a key.

        Args:
            event: a press or release; keys without a meaning change nothing.
            now: the time [s], of any clock that does not jump.
        """
        if event.key in DIRECTIONS:
            self._is_slow = event.has_shift
        if event.is_release:
            self._held.pop(event.key, None)
        elif event.key in DIRECTIONS:
            self._hold(event, now)
        elif event.key in _FACTORS:
            speed, turn = _FACTORS[event.key]
            self.speed *= speed
            self.turn *= turn
        elif event.key in STOPS:
            self.stop()

    def _hold(self, event: KeyEvent, now: float) -> None:
        if event.has_releases:
            self._held[event.key] = float("inf")
            return
        repeats = self._held.get(event.key, now) > now
        # Such a terminal repeats the last key alone: the others may have been released.
        self._held = {event.key: now + (self._repeat_timeout if repeats else self._first_timeout)}

    def stop(self) -> None:
        """Counts all keys as released."""
        self._held.clear()

    def command(self, now: float) -> Command:
        """The command at a time [s]; zeros if no key is held."""
        self._held = {key: until for key, until in self._held.items() if until > now}
        return command(self._held, self.speed, self.turn, self._is_slow)

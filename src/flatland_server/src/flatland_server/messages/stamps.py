"""Stamps: the times in messages and transforms, for simulated times.

They are equal, unless the server stamps with real time (`WallTimekeeper`): then there is an offset
between them. It is one of the process, as ROS's own clock is.
"""

from typing import Tuple

from flatland_server import _core

_offset = 0  # ns


def stamp_of(nanoseconds: int) -> Tuple[int, int]:
    """The stamp of a simulated time: seconds, and nanoseconds in [0, 1e9).

    Args:
        nanoseconds: simulated time [ns].
    """
    return divmod(nanoseconds + _offset, 1_000_000_000)


def stamp_offset() -> int:
    """The difference between stamps and simulated time [ns]."""
    return _offset


def set_stamp_offset(nanoseconds: int) -> None:
    """Sets the difference between stamps and simulated time [ns], of Python and of the core."""
    global _offset
    _offset = nanoseconds
    _core.set_stamp_offset(nanoseconds)

"""The observation of a batch of environments."""

from functools import lru_cache
from typing import List, NamedTuple, Optional, Tuple

import numpy as np

from flatland_server.arrays import BoolArray, Float32Array, FloatArray
from flatland_server.exceptions import UsageError


class BatchObservation(NamedTuple):
    """Arrays with a row for each of n environments, C-contiguous.

    Of a batch with m `robots`, all but `times` have the shape (n, m, ...) instead of (n, ...).
    """

    ranges: Float32Array
    """(n, beams), float32: of each beam [m]; one that hits nothing is +inf (REP 117)."""
    poses: FloatArray
    """(n, 3), float64: x, y [m] and yaw in [-pi, pi] [rad] of the robot's first body."""
    velocities: FloatArray
    """(n, 3), float64: vx, vy [m/s] and omega [rad/s] of its origin, in the world's frame."""
    local_velocities: FloatArray
    """(n, 3), float64: the same in the body's frame: forwards, to the left, counter-clockwise."""
    collided: BoolArray
    """(n,), bool: whether the robot touched something solid during the last call of `step`."""
    times: FloatArray
    """(n,), float64: simulated time since the last reset, or that of the state [s]."""

    @classmethod
    def empty(cls, count: int, beams: int, robots: Optional[int] = None) -> "BatchObservation":
        """New arrays, with any content.

        Args:
            count: number of environments, n.
            beams: number of beams of the lidar.
            robots: number of robots, m; None for arrays of the shape (n, ...).
        """
        return cls._make(np.empty(shape, dtype) for shape, dtype in _forms(count, beams, robots))

    def copy(self) -> "BatchObservation":
        """A copy with arrays of its own."""
        return BatchObservation._make(array.copy() for array in self)

    def check(self, count: int, beams: int, robots: Optional[int] = None) -> None:
        """Checks that a batch can write to the arrays.

        Args:
            count: its number of environments.
            beams: number of beams of its lidar.
            robots: as for `empty`.

        Raises:
            UsageError: one has another shape or type, or cannot be written to in place.
        """
        for name, array, (shape, dtype) in zip(self._fields, self, _forms(count, beams, robots)):
            found = type(array).__name__
            if isinstance(array, np.ndarray):
                fits = array.shape == shape and array.dtype == dtype
                flags = array.flags
                if fits and flags.carray:  # C's order, aligned and writeable
                    continue
                found = f"{array.dtype} of shape {array.shape}"
                found += ", not writeable in C's order" if fits else ""
            raise UsageError(f"expected out.{name} as {dtype} of shape {shape}, found {found}")


@lru_cache(maxsize=64)
def _forms(
    count: int, beams: int, robots: Optional[int]
) -> List[Tuple[Tuple[int, ...], "np.dtype[np.generic]"]]:
    """The shape and type of each array."""
    number = np.dtype(np.float64)
    rows = (count,) if robots is None else (count, robots)
    return [
        ((*rows, beams), np.dtype(np.float32)),
        ((*rows, 3), number),
        ((*rows, 3), number),
        ((*rows, 3), number),
        (rows, np.dtype(bool)),
        ((count,), number),
    ]

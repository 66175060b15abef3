"""Maps of rooms, made by chance."""

from dataclasses import dataclass
from typing import Tuple

import numpy as np

from flatland2d import UsageError
from flatland_gym.settings import is_whole
from flatland_server import FloatArray, Segments


@dataclass(frozen=True)
class Rooms:
    """Makes maps of rooms with doors between them, and with boxes in them.

        gymnasium.make_vec(..., world="empty_room", maps=Rooms(), num_maps=300)

    A rectangle is cut in two, and so is each part that is larger than `room`, by a wall with a
    door: all rooms are connected, but where a box stands in a door.

    Attributes:
        size: of the floor, along x and y [m]; its middle is the origin.
        room: the largest side of a room [m].
        door: the least width of a door [m]; no door is twice as wide.
        boxes: how many boxes there are, at random places; some share one.
        box: the least and the largest side of a box [m].
    """

    size: Tuple[float, float] = (20.0, 20.0)
    room: float = 7.0
    door: float = 1.1
    boxes: int = 40
    box: Tuple[float, float] = (0.2, 0.8)

    def __post_init__(self) -> None:
        """Raises a UsageError for a value that is not usable."""
        try:
            (length, width), (least, largest) = self.size, self.box
            numbers = np.array([length, width, self.room, self.door, least, largest], np.float64)
            is_right = bool(np.isfinite(numbers).all() and numbers.min() >= 0.0)
            is_right = is_right and least <= largest <= min(length, width)
        except (TypeError, ValueError, OverflowError):
            is_right = False
        if not (is_right and is_whole(self.boxes) and self.boxes >= 0):
            raise UsageError(
                "expected finite sizes of 0 or more, boxes no larger than the floor, and a whole "
                f"number of them, found {self}"
            )
        if not 0.0 < 6.0 * self.door <= min(self.room, *self.size):
            raise UsageError(
                f"expected a floor and rooms of at least six doors, {6.0 * self.door:g} m, found "
                f"{self}"
            )

    def __call__(self, rng: np.random.Generator) -> Segments:
        """The walls of a map: shape (n, 4) [m]."""
        size = np.array(self.size)
        half, cells = size / 2.0, np.floor(size / self.door).astype(int)
        pitch = size / cells
        walls = [_rectangles(-half[None], half[None])]
        # Walls stand on the lines of a grid, doors are between two lines: no wall ends in a door.
        parts = [(np.zeros(2, int), cells)]
        while parts:
            low, high = parts.pop()
            axis = int(np.argmax(high - low))
            length = high[axis] - low[axis]
            if length * pitch[axis] <= self.room:
                continue
            line = low[axis] + rng.integers(length // 3 + 1, length - length // 3)
            door = rng.integers(low[1 - axis], high[1 - axis])
            for begin, end in ((low[1 - axis], door), (door + 1, high[1 - axis])):
                if begin == end:
                    continue
                ends = np.array([[line, begin], [line, end]])[:, :: 1 - 2 * axis]
                walls.append((ends * pitch - half).reshape(1, 4))
            below, above = high.copy(), low.copy()
            below[axis] = above[axis] = line
            parts += [(low, below), (above, high)]
        sides = rng.uniform(*self.box, (self.boxes, 2))
        corners = rng.uniform(-half, half - sides)
        walls.append(_rectangles(corners, corners + sides))
        return np.concatenate(walls)


def _rectangles(low: FloatArray, high: FloatArray) -> Segments:
    """The sides of rectangles, from their corners (n, 2): shape (4 n, 4)."""
    (x, y), (u, v) = low.T, high.T
    sides = [(x, y, u, y), (u, y, u, v), (u, v, x, v), (x, v, x, y)]
    return np.concatenate([np.column_stack(side) for side in sides])

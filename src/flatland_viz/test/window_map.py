"""The window's view of the test room: where a point of the world is on the screen."""

import numpy as np
from screen_pictures import near

ROOM = (-5.0, -3.0, 5.0, 3.0)  # of the test room [m]


class RoomMap:
    """The pixels of the test room in a screenshot, found by its walls.

    Args:
        pixels: a screenshot in which the whole room is seen, unrotated.
        color: its walls' color.
        rows: of the view, as a slice.
        columns: of the view, as a slice.

    Raises:
        LookupError: the walls are not found.
    """

    def __init__(self, pixels, color, rows, columns):
        view = pixels[rows, columns]
        lines = near(view, color, 45)
        lines |= (view.max(axis=2) > 150) & (view.min(axis=2) < 60)  # scans, which cover walls
        across = np.nonzero(lines.sum(axis=1) > 0.4 * view.shape[1])[0]  # short lines are text
        down = np.nonzero(lines.sum(axis=0) > 0.4 * view.shape[0])[0]
        if len(across) < 2 or len(down) < 2:
            raise LookupError("the room's walls are not seen")
        min_x, min_y, max_x, max_y = ROOM
        self.scale = np.ptp(down) / (max_x - min_x)
        if abs(np.ptp(across) / (max_y - min_y) / self.scale - 1.0) > 0.05:
            raise LookupError("these are not the room's walls")
        self._u = columns.start + (down.min() + down.max() + 1) / 2
        self._v = rows.start + (across.min() + across.max() + 1) / 2

    def pixel(self, x, y):
        """The pixel of a point in the world [m]."""
        return round(self._u + self.scale * x), round(self._v - self.scale * y)

    def around(self, x, y, reach):
        """Rows and columns of the square around a point [m], for slicing screenshots."""
        u, v = self.pixel(x, y)
        pixels = round(reach * self.scale)
        return slice(v - pixels, v + pixels + 1), slice(u - pixels, u + pixels + 1)

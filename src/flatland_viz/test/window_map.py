"""The window's view of the test room: where a point of the world is on the screen."""

import numpy as np

ROOM = (-5.0, -3.0, 5.0, 3.0)  # of the test room [m]


def near(pixels, color, tolerance=40):
    return np.abs(pixels - np.array(color)).max(axis=2) <= tolerance


class RoomMap:
    """The pixels of the test room in a screenshot, found by its walls.

    Args:
        pixels: a screenshot in which the whole room is seen, unrotated.

    Raises:
        LookupError: it is not.
    """

    def __init__(self, pixels):
        # Thin lines; scans may cover some. Text has short ones only.
        lines = (pixels.min(axis=2) < 130) & (pixels.max(axis=2) > 40)
        rows = np.nonzero(lines.sum(axis=1) > 0.3 * pixels.shape[1])[0]
        columns = np.nonzero(lines.sum(axis=0) > 0.3 * pixels.shape[0])[0]
        if len(rows) < 2 or len(columns) < 2:
            raise LookupError("the room's walls are not seen")
        min_x, min_y, max_x, max_y = ROOM
        self.scale = (columns.max() - columns.min()) / (max_x - min_x)
        if abs((rows.max() - rows.min()) / (max_y - min_y) / self.scale - 1.0) > 0.05:
            raise LookupError("these are not the room's walls")
        self._u = (columns.min() + columns.max() + 1) / 2
        self._v = (rows.min() + rows.max() + 1) / 2

    def pixel(self, x, y):
        """Of a point in the world [m]."""
        return round(self._u + self.scale * x), round(self._v - self.scale * y)

    def around(self, x, y, reach):
        """Rows and columns of the square around a point [m], for slicing screenshots."""
        u, v = self.pixel(x, y)
        pixels = round(reach * self.scale)
        return slice(v - pixels, v + pixels + 1), slice(u - pixels, u + pixels + 1)

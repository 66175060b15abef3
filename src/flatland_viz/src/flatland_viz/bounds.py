"""The extent of a world, and the view that shows all of it from above.

A box without content is null.
"""

import math
from typing import NamedTuple

from python_qt_binding.QtCore import QRectF


class View(NamedTuple):
    """The centre of rviz's TopDownOrtho view [m], and its scale [pixels per metre]."""

    x: float
    y: float
    scale: float


class Grid(NamedTuple):
    """An rviz grid: its centre [m], the size of a cell [m] and their number along each side."""

    x: float
    y: float
    cell_size: float
    cells: int


_OPEN_SIDE = 10.0  # m: the least side of a world without walls
_MARGIN = 0.08  # of the view, altogether
_MIN_SIDE = 0.5  # m: a single short wall is not magnified further


def extent(walls: QRectF, models: QRectF) -> QRectF:
    """The box around a world [m].

    Args:
        walls: the box around all walls. Without walls the world is at least 10 x 10 m large: a
            single robot does not fill the view.
        models: the box around all models.
    """
    if not walls.isNull():
        return walls.united(models)
    floor = QRectF(0.0, 0.0, _OPEN_SIDE, _OPEN_SIDE)
    floor.moveCenter(models.center())
    return floor.united(models)


def framed(bounds: QRectF, width: float, height: float) -> View:
    """The view that shows a box in a panel of `width` x `height` pixels."""
    across, along = max(bounds.width(), _MIN_SIDE), max(bounds.height(), _MIN_SIDE)
    scale = (1 - _MARGIN) * min(width / across, height / along)
    return View(bounds.center().x(), bounds.center().y(), scale)


def grid_around(bounds: QRectF) -> Grid:
    """A grid that reaches beyond a box, of cells of 1, 10, 100 ... m and at most 200 a side."""
    side = 2 * max(bounds.width(), bounds.height(), 10.0)
    cell_size = 10.0 ** max(0, math.ceil(math.log10(side / 200)))
    return Grid(
        round(bounds.center().x() / cell_size) * cell_size,
        round(bounds.center().y() / cell_size) * cell_size,
        cell_size,
        2 * math.ceil(side / 2 / cell_size),  # even: its lines are at whole cells
    )

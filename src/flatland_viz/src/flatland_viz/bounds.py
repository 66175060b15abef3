"""The extent of a world, and the view that shows all of it from above."""

import math
from typing import Iterable, List, NamedTuple, Optional

import numpy as np


class Bounds(NamedTuple):
    """A box [m]."""

    min_x: float
    min_y: float
    max_x: float
    max_y: float

    @property
    def width(self) -> float:
        """Along x [m]."""
        return self.max_x - self.min_x

    @property
    def height(self) -> float:
        """Along y [m]."""
        return self.max_y - self.min_y


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


EMPTY_WORLD = Bounds(-5.0, -5.0, 5.0, 5.0)
_OPEN_SIDE = 10.0  # m: the least side of a world without walls
_MARGIN = 0.08  # of the view, altogether
_MIN_SIDE = 0.5  # m: a single short wall is not magnified further


def around(boxes: Iterable[Optional[Bounds]]) -> Bounds:
    """The bounding box of boxes; 10 x 10 m about the origin if there are none."""
    known: List[Bounds] = [box for box in boxes if box is not None]
    if not known:
        return EMPTY_WORLD
    lows, highs = np.array(known)[:, :2].min(axis=0), np.array(known)[:, 2:].max(axis=0)
    return Bounds(*map(float, (*lows, *highs)))


def extent(walls: Optional[Bounds], models: Optional[Bounds]) -> Bounds:
    """The box around a world.

    Args:
        walls: the box around all walls; None if there are none. Then the world is at least
            10 x 10 m large: a single robot does not fill the view.
        models: the box around all models; None if there are none.
    """
    if walls is not None or models is None:
        return around([walls, models])
    x, y = (models.min_x + models.max_x) / 2, (models.min_y + models.max_y) / 2
    half = _OPEN_SIDE / 2
    return around([models, Bounds(x - half, y - half, x + half, y + half)])


def framed(bounds: Bounds, width: int, height: int) -> View:
    """The view that shows a box in a panel of `width` x `height` pixels."""
    return View(
        (bounds.min_x + bounds.max_x) / 2,
        (bounds.min_y + bounds.max_y) / 2,
        (1 - _MARGIN)
        * min(width / max(bounds.width, _MIN_SIDE), height / max(bounds.height, _MIN_SIDE)),
    )


def grid_around(bounds: Bounds) -> Grid:
    """A grid that reaches beyond a box, of cells of 1, 10, 100 ... m and at most 200 a side."""
    side = 2 * max(bounds.width, bounds.height, 10.0)
    cell_size = 10.0 ** max(0, math.ceil(math.log10(side / 200)))
    return Grid(
        round((bounds.min_x + bounds.max_x) / 2 / cell_size) * cell_size,
        round((bounds.min_y + bounds.max_y) / 2 / cell_size) * cell_size,
        cell_size,
        2 * math.ceil(side / 2 / cell_size),  # even: its lines are at whole cells
    )


def bounds_in(text: str) -> Optional[Bounds]:
    """The box in the property "Bounds" of the displays of walls and models; None if it is empty."""
    return Bounds(*map(float, text.split())) if text else None

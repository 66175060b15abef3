"""The extent of a world, and the view that shows all of it from above."""

import math
import struct
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
_MARGIN = 0.08  # of the view, altogether
_MIN_SIDE = 0.5  # m: a single short wall is not magnified further


def around(boxes: Iterable[Optional[Bounds]]) -> Bounds:
    """The bounding box of boxes; 10 x 10 m about the origin if there are none."""
    known: List[Bounds] = [box for box in boxes if box is not None]
    if not known:
        return EMPTY_WORLD
    lows, highs = np.array(known)[:, :2].min(axis=0), np.array(known)[:, 2:].max(axis=0)
    return Bounds(*map(float, (*lows, *highs)))


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


def bounds_of_markers(data: bytes) -> Optional[Bounds]:
    """The bounding box of a serialized visualization_msgs/MarkerArray; None if it has no points.

    A layer may have a million points. rospy would make an object of each, which takes seconds; this
    reads the coordinates in place. Markers' poses are assumed to be the origin, as those of layers.
    """
    boxes = []
    (count,), at = struct.unpack_from("<I", data), 4
    for _ in range(count):
        at = _after_list(data, at + 12, 1)  # header: seq, stamp; frame_id
        at = _after_list(data, at, 1)  # ns
        at += 12 + 56 + 24 + 16 + 8 + 1  # id, type, action; pose; scale; color; lifetime; locked
        (points,) = struct.unpack_from("<I", data, at)
        if points:
            xy = np.frombuffer(data, "<f8", 3 * points, at + 4).reshape(-1, 3)[:, :2]
            boxes.append(Bounds(*map(float, (*xy.min(axis=0), *xy.max(axis=0)))))
        at = _after_list(data, at, 24)  # points
        at = _after_list(data, at, 16)  # colors
        at = _after_list(data, at, 1)  # text
        at = _after_list(data, at, 1) + 1  # mesh_resource, mesh_use_embedded_materials
    return around(boxes) if boxes else None


def _after_list(data: bytes, at: int, item: int) -> int:
    """The end of a list or string that begins with its length at `at`.

    Args:
        data: the message.
        at: the offset of the list.
        item: the size of an item [bytes].
    """
    (length,) = struct.unpack_from("<I", data, at)
    return at + 4 + int(length) * item

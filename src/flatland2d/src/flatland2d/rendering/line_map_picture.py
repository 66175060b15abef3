"""Draws a map and the lines that were made from it, one above the other."""

from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image

from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.rendering.renderer import write_picture
from flatland2d.rendering.svg_canvas import SvgCanvas
from flatland2d.rendering.view import View, fitting_size
from flatland_server.canvas import Canvas
from flatland_server.maps import LineMap

C = TypeVar("C", bound=Canvas)

_LONGER_SIDE = 2400  # px
_BACKGROUND = (1.0, 1.0, 1.0, 1.0)
_OUTLINES = (0.80, 0.80, 0.78, 1.0)
_LINES = (0.80, 0.15, 0.10, 1.0)
_CORNERS = (0.10, 0.20, 0.60, 1.0)


def save_line_map_picture(path: Path, line_map: LineMap) -> None:
    """Draws outlines in grey, lines in red, and their ends as blue dots.

    Args:
        path: of the picture; SVG if it ends in .svg, or else PNG, JPEG ...
        line_map: the map and its lines.

    Raises:
        FlatlandError: the file cannot be written, or its kind is not known.
    """
    corners = line_map.in_world(line_map.outlines).reshape(-1, 2)
    if not len(corners):
        corners = np.zeros((1, 2))
    low, high = (tuple(limit(axis=0).tolist()) for limit in (corners.min, corners.max))
    size = fitting_size(low, high, _LONGER_SIDE)
    view = View.of(low, high, size)
    write_picture(
        path,
        lambda: _drawn(SvgCanvas(view, _BACKGROUND), line_map).document(),
        lambda: _drawn(ImageCanvas(Image.new("RGB", size, "white"), view), line_map).image,
    )


def _drawn(canvas: C, line_map: LineMap) -> C:
    lines = line_map.in_world(line_map.lines)
    canvas.lines(line_map.in_world(line_map.outlines), _OUTLINES, 4.0)
    canvas.lines(lines, _LINES, 1.5)
    canvas.dots(np.unique(lines.reshape(-1, 2), axis=0), _CORNERS, 3.0)
    return canvas

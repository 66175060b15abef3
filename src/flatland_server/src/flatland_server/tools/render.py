"""Draws a world as seen from above, to look at it without rviz."""

from typing import List, Tuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from flatland_server.arrays import FloatArray
from flatland_server.config.yaml_reader import Color
from flatland_server.geometry import Point
from flatland_server.simulation.world import World

_LONGER_SIDE = 1600  # px
_MARGIN = 40  # px
_LEAST_EXTENT = 2.0  # m
_BACKGROUND = (238, 238, 236)
_NAMES = (32, 32, 32)


class _View:
    """Converts metres in the world to pixels of the picture: x to the right, y upwards.

    Args:
        points: that the picture must show [m]: shape (n, 2).
    """

    def __init__(self, points: FloatArray) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        grow = np.maximum(0.0, _LEAST_EXTENT - (high - low)) / 2
        low, high = low - grow, high + grow
        self.scale = (_LONGER_SIDE - 2 * _MARGIN) / float((high - low).max())
        self._low_x, self._high_y = float(low[0]), float(high[1])
        width, height = ((high - low) * self.scale).round().astype(int) + 2 * _MARGIN
        self.size = (int(width), int(height))

    def __call__(self, x: float, y: float) -> Point:
        return (
            _MARGIN + (x - self._low_x) * self.scale,
            _MARGIN + (self._high_y - y) * self.scale,
        )


def render(world: World) -> Image.Image:
    """A picture of walls, footprints and names of models; its longer side has 1600 pixels."""
    shapes = _shapes(world)
    corners = [point for outline, _ in shapes for point in outline]
    corners += [model.pose[:2] for model in world.models.values()]
    walls = [layer.segments.reshape(-1, 2) for layer in world.layers]
    view = _View(np.concatenate([*walls, np.reshape(corners or [(0.0, 0.0)], (-1, 2))]))

    image = Image.new("RGB", view.size, _BACKGROUND)
    draw = ImageDraw.Draw(image, "RGBA")
    for layer in world.layers:
        color = _rgba(layer.config.color)
        for x1, y1, x2, y2 in layer.segments.tolist():
            draw.line([view(x1, y1), view(x2, y2)], fill=color, width=2)
    for outline, shape_color in shapes:
        pixels = [view(*point) for point in outline]
        fill = _rgba(shape_color)
        draw.polygon(pixels, fill=fill, outline=(*fill[:3], 255))
    font = ImageFont.load_default()
    for model in world.models.values():
        draw.text(view(*model.pose[:2]), model.name, fill=_NAMES, font=font)
    return image


def _shapes(world: World) -> List[Tuple[List[Point], Color]]:
    """The outlines of all footprints in the world [m], with their colours."""
    return [
        ([body.pose.apply(*corner) for corner in footprint.shape.outline()], body.config.color)
        for model in world.models.values()
        for body in model.bodies.values()
        for footprint in body.config.footprints
    ]


def _rgba(color: Color) -> Tuple[int, int, int, int]:
    """A colour with parts from 0 to 255."""
    red, green, blue, alpha = (round(255 * part) for part in color)
    return red, green, blue, alpha

"""The ground and the walls of pictures, which do not move: drawn once, in square tiles."""

from typing import Dict, List, Sequence, Tuple

import numpy as np
from PIL import Image

from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.rendering.scene import BACKGROUND, draw_ground, draw_walls
from flatland2d.rendering.view import View
from flatland_server.arrays import Segments
from flatland_server.canvas import Rgba
from flatland_server.models import Layer

_SIDE = 512  # px
_KEPT = 40  # tiles; 0.8 MB each

_Key = Tuple[float, int, int]
"""Scale [px/m], column and row of a tile."""


class Tiles:
    """Draws ground and walls, and keeps what it has drawn until the walls change."""

    def __init__(self) -> None:
        self._tiles: Dict[_Key, Image.Image] = {}
        self._walls: List[Tuple[Segments, Rgba]] = []

    def image(self, view: View, layers: Sequence[Layer]) -> Image.Image:
        """A new image of the ground and the walls of these layers."""
        if self._have_changed(layers):
            self._tiles.clear()
            self._walls = [(layer.segments, layer.config.color) for layer in layers]
        image = Image.new("RGB", view.size)
        width, height = view.size
        columns = range(view.left // _SIDE, (view.left + width - 1) // _SIDE + 1)
        rows = range(view.top // _SIDE, (view.top + height - 1) // _SIDE + 1)
        for column in columns:
            for row in rows:
                tile = self._tile((view.scale, column, row), layers)
                image.paste(tile, (column * _SIDE - view.left, row * _SIDE - view.top))
        while len(self._tiles) > max(_KEPT, len(columns) * len(rows)):
            del self._tiles[next(iter(self._tiles))]  # the least recently used one
        return image

    def _have_changed(self, layers: Sequence[Layer]) -> bool:
        return len(layers) != len(self._walls) or not all(
            layer.config.color == color
            and (layer.segments is segments or np.array_equal(layer.segments, segments))
            for layer, (segments, color) in zip(layers, self._walls)
        )

    def _tile(self, key: _Key, layers: Sequence[Layer]) -> Image.Image:
        tile = self._tiles.pop(key, None)
        if tile is None:
            scale, column, row = key
            view = View(column * _SIDE, row * _SIDE, scale, (_SIDE, _SIDE))
            red, green, blue = (round(255 * part) for part in BACKGROUND[:3])
            tile = Image.new("RGB", view.size, (red, green, blue))
            canvas = ImageCanvas(tile, view)
            draw_ground(canvas, view)
            draw_walls(canvas, layers, scale)
        self._tiles[key] = tile  # to the end: the most recently used one
        return tile

"""A canvas on a Pillow image, with anti-aliased edges.

Pillow draws without anti-aliasing. So each shape is drawn several times as large, on a mask of its
own that is only as large as the shape; the mask, reduced, says how much of each pixel the colour
covers.
"""

from functools import lru_cache
from typing import Callable, List, Optional

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from flatland2d.rendering.view import View
from flatland_server.arrays import FloatArray, Segments
from flatland_server.canvas import Canvas, Points, Rgba
from flatland_server.geometry import Point

_FINE = 4
"""The scale of masks, relative to the image."""

_COARSE = 2
"""The scale of masks of large areas and of dots that lie far apart, to save time."""

_LARGE = 1 << 17  # px
_LABEL_OFFSET = (4, 3)  # px
_FONT_SIZE = 18  # px
_PIXEL_FONT_SIZE = 11  # px
_LABEL_COLOR = (238, 238, 236)
_LABEL_GROUND = 200  # of 255: opacity behind a label
_LARGEST = 1e6  # px; Pillow computes with 32 bits

_Draw = Callable[[ImageDraw.ImageDraw, FloatArray, int], None]
"""Draws on a mask enlarged by a factor; the array has the shape's points on the mask: (n, 2)."""


class ImageCanvas(Canvas):
    """Draws on an RGB image.

    Args:
        image: RGB image to draw on; it is changed in place.
        view: what it shows; its size must be that of the image.
    """

    def __init__(self, image: Image.Image, view: View) -> None:
        self.image = image
        self.view = view

    def area(
        self,
        corners: Points,
        fill: Optional[Rgba] = None,
        outline: Optional[Rgba] = None,
        width: float = 1.0,
    ) -> None:
        pixels = self.view.pixels(corners)
        if fill is not None:
            self._stamp(pixels, 1.0, fill, lambda draw, at, _: draw.polygon(_flat(at), fill=255))
        if outline is not None:

            def draw_outline(draw: ImageDraw.ImageDraw, at: FloatArray, factor: int) -> None:
                closed = np.vstack([at, at[:2]])  # its last corner is round too
                draw.line(_flat(closed), fill=255, width=_whole(factor * width), joint="curve")

            self._stamp(pixels, width, outline, draw_outline)

    def disc(
        self,
        center: Point,
        radius: float,
        fill: Optional[Rgba] = None,
        outline: Optional[Rgba] = None,
        width: float = 1.0,
    ) -> None:
        x, y = self.view.pixels([center])[0].tolist()
        reach = radius * self.view.scale
        box = np.array([(x - reach, y - reach), (x + reach, y + reach)])
        if fill is not None:
            self._stamp(box, 1.0, fill, lambda draw, at, _: draw.ellipse(_flat(at), fill=255))
        if outline is not None:
            box += (-width / 2, -width / 2), (width / 2, width / 2)

            def draw_ring(draw: ImageDraw.ImageDraw, at: FloatArray, factor: int) -> None:
                draw.ellipse(_flat(at), outline=255, width=_whole(factor * width))

            self._stamp(box, width, outline, draw_ring)

    def lines(self, segments: Segments, color: Rgba, width: float = 1.0) -> None:
        ends = self.view.pixels(segments).reshape(-1, 2, 2)
        low, high = ends.min(axis=1) - width, ends.max(axis=1) + width
        ends = ends[((high > 0) & (low < self.view.size)).all(axis=1)]
        if not len(ends):
            return
        # Square ends, so that two segments that meet at a right angle make a full corner.
        along = ends[:, 1] - ends[:, 0]
        length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)[:, None]
        cap = along / length * (width / 2)
        ends[:, 0] -= cap
        ends[:, 1] += cap

        def draw_segments(draw: ImageDraw.ImageDraw, at: FloatArray, factor: int) -> None:
            line = _whole(factor * width)
            for segment in at.reshape(-1, 4).tolist():
                draw.line(segment, fill=255, width=line)

        self._stamp(ends.reshape(-1, 2), width, color, draw_segments, is_fine=True)

    def path(self, points: Points, color: Rgba, width: float = 1.0) -> None:
        pixels = self.view.pixels(points)

        def draw_path(draw: ImageDraw.ImageDraw, at: FloatArray, factor: int) -> None:
            draw.line(_flat(at), fill=255, width=_whole(factor * width), joint="curve")

        if len(pixels) > 1:
            self._stamp(pixels, width, color, draw_path)

    def dots(self, points: Points, color: Rgba, size: float = 3.0) -> None:
        pixels = self.view.pixels(points)
        pixels = pixels[((pixels > -size) & (pixels < np.add(self.view.size, size))).all(axis=1)]

        def draw_dots(draw: ImageDraw.ImageDraw, at: FloatArray, factor: int) -> None:
            reach = factor * size / 2
            for box in np.hstack([at - reach, at + reach]).tolist():
                draw.ellipse(box, fill=255)

        if len(pixels):
            self._stamp(pixels, size, color, draw_dots)

    def label(self, point: Point, text: str, color: Rgba) -> None:
        x, y = self.view.pixels([point])[0].tolist()
        if not -_LARGEST < x < _LARGEST or not -_LARGEST < y < _LARGEST:
            return
        place = round(x) + _LABEL_OFFSET[0], round(y) + _LABEL_OFFSET[1]
        letters = _letters(text)
        ground = Image.new("L", letters.size, _LABEL_GROUND)
        self.image.paste(_LABEL_COLOR, place, ground)
        self.image.paste(_rgb(color), place, letters)

    def _stamp(
        self, pixels: FloatArray, grow: float, color: Rgba, draw: _Draw, *, is_fine: bool = False
    ) -> None:
        """Blends a colour into the image where `draw` draws white on an enlarged mask.

        Args:
            pixels: of the shape: shape (n, 2).
            grow: how far the shape extends beyond them [px].
            color: colour of the drawing.
            draw: called with the mask to draw on, the points in its pixels, and its enlargement.
            is_fine: whether to use `_FINE` for a large mask, too.
        """
        if not np.isfinite(pixels).all():
            return
        pixels = np.clip(pixels, -_LARGEST, _LARGEST)
        low = np.maximum(np.floor(pixels.min(axis=0) - grow), 0).astype(int)
        high = np.minimum(np.ceil(pixels.max(axis=0) + grow) + 1, self.view.size).astype(int)
        width, height = (high - low).tolist()
        if width <= 0 or height <= 0:
            return
        factor = _FINE if is_fine or width * height < _LARGE else _COARSE
        mask = Image.new("L", (factor * width, factor * height))
        # Pillow's coordinates are those of the pixels' centres.
        draw(ImageDraw.Draw(mask), (pixels - low) * factor - 0.5, factor)
        mask = mask.reduce(factor)
        if color[3] < 1.0:
            mask = mask.point([round(color[3] * value) for value in range(256)])
        self.image.paste(_rgb(color), tuple(low.tolist()), mask)


@lru_cache(maxsize=256)
def _letters(text: str) -> Image.Image:
    """A string as a mask, in Pillow's own font, the same on all machines.

    Before Pillow 10.1 it is a bitmap font, which is enlarged.
    """
    try:
        font, height = ImageFont.load_default(size=_FONT_SIZE), _FONT_SIZE
    except TypeError:
        font, height = ImageFont.load_default(), _PIXEL_FONT_SIZE
    _, _, right, bottom = ImageDraw.Draw(Image.new("L", (1, 1))).textbbox((0, 0), text, font)
    mask = Image.new("L", (max(right, 1), max(bottom, 1)))
    ImageDraw.Draw(mask).text((0, 0), text, fill=255, font=font)
    width, tall = (round(side * _FONT_SIZE / height) for side in mask.size)
    return mask if height == _FONT_SIZE else mask.resize((width, tall), Image.BICUBIC)


def _whole(width: float) -> int:
    """The width of a line in whole pixels, at least one."""
    return max(1, round(width))


def _flat(pixels: FloatArray) -> List[float]:
    """Pixels as Pillow takes them fastest: x, y, x, y ..."""
    flat: List[float] = pixels.ravel().tolist()
    return flat


def _rgb(color: Rgba) -> "tuple[int, int, int]":
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in color[:3])
    return red, green, blue

"""Draws a world, into an image or a file."""

import io
import os
import sys
from numbers import Real
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np
from PIL import Image

from flatland2d.rendering import scene
from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.rendering.scene import BACKGROUND, draw_ground, draw_walls
from flatland2d.rendering.svg_canvas import SvgCanvas
from flatland2d.rendering.view import Size, View, fitting_size
from flatland_server.arguments import path_of, shown
from flatland_server.arrays import Segments, UInt8Array
from flatland_server.canvas import Canvas, Points, Rgba
from flatland_server.exceptions import FlatlandError, UsageError
from flatland_server.models import Layer
from flatland_server.simulation import World
from flatland_server.timekeeper import Timekeeper

LONGER_SIDE = 1600
"""The longer side of a picture of the whole world, if no size is given [px]."""

FOLLOWED_SIZE = (800, 800)
"""The size of a picture around a model, if none is given [px]."""


class Renderer:
    """Draws pictures of a world, and keeps the ground and the walls for the next one.

    Args:
        world: to draw; it may be reset, and its models and walls may change.
        timekeeper: has the time at which sensors measure; by default it is 0.
    """

    def __init__(self, world: World, timekeeper: Optional[Timekeeper] = None) -> None:
        self.world = world
        self.timekeeper = timekeeper or Timekeeper(0.005)
        self._tiles = Tiles()

    def view(
        self, size: Optional[Size] = None, *, follow: Optional[str] = None, width: float = 10.0
    ) -> View:
        """The whole world, or the area around a model.

        Args:
            size: of the picture [px]; by default the longer side has 1600 pixels, or both have 800
                if a model is followed.
            follow: the model in the middle of the picture.
            width: of the section of the world that is shown around it [m].

        Raises:
            ModelError: there is no such model.
            FlatlandError: the size or the width is not usable.
        """
        if follow is None:
            low, high = scene.bounds(self.world)
            return View.of(low, high, size or fitting_size(low, high, LONGER_SIDE))
        if not (isinstance(width, Real) and 0.0 < width <= sys.float_info.max):
            raise UsageError(f"expected a width above 0 m, found {shown(width)}")
        size = size or FOLLOWED_SIZE
        return View.around(self.world.get_model(follow).pose[:2], size[0] / width, size)

    def image(
        self,
        view: Optional[View] = None,
        *,
        sensors: bool = False,
        names: bool = False,
        trails: Iterable[Points] = (),
    ) -> Image.Image:
        """A picture of the world as it is now.

        Args:
            view: the section to show; by default the whole world.
            sensors: whether plugins draw what they measure; see `Plugin.draw`.
            names: whether the names of the models are written beside them.
            trails: lines through positions in the world [m]: shape (n, 2) each.
        """
        view = view or self.view()
        image = self._tiles.image(view, self.world.layers)
        self._draw(ImageCanvas(image, view), view, sensors, names, trails)
        return image

    def svg(
        self,
        view: Optional[View] = None,
        *,
        sensors: bool = False,
        names: bool = False,
        trails: Iterable[Points] = (),
    ) -> str:
        """The same as `image`, as an SVG document."""
        view = view or self.view()
        canvas = SvgCanvas(view, scene.BACKGROUND)
        scene.draw_ground(canvas, view)
        scene.draw_walls(canvas, self.world.layers, view.scale)
        self._draw(canvas, view, sensors, names, trails)
        return canvas.document()

    def _draw(
        self, canvas: Canvas, view: View, sensors: bool, names: bool, trails: Iterable[Points]
    ) -> None:
        """Draws everything but the ground and the walls."""
        models = list(self.world.models.values())
        scene.draw_trails(canvas, trails)
        if sensors:
            self.world.contents.plugins.draw(canvas, self.timekeeper)
        for model in models:
            scene.draw_model(canvas, model, view.scale)
        if names:
            for model in models:
                scene.draw_name(canvas, model)


def save(
    path: Union[str, "os.PathLike[str]"],
    renderer: Renderer,
    view: Optional[View] = None,
    *,
    sensors: bool = False,
    names: bool = False,
    trails: Iterable[Points] = (),
) -> None:
    """Writes a picture into a file: SVG if its name ends in .svg, or else PNG, JPEG ...

    Args: the path, the world's renderer, and those of `Renderer.image`.

    Raises:
        FlatlandError: the file cannot be written, or its kind is not known.
    """
    options: Any = {"sensors": sensors, "names": names, "trails": trails}
    found = path_of(path, "the path of a picture")
    write_picture(
        found, lambda: renderer.svg(view, **options), lambda: renderer.image(view, **options)
    )


def write_picture(path: Path, svg: Callable[[], str], image: Callable[[], Image.Image]) -> None:
    """Writes a picture into a file: SVG if its name ends in .svg, or else PNG, JPEG ...

    Raises:
        FlatlandError: the file cannot be written, or its kind is not known.
    """
    try:
        if path.suffix.lower() == ".svg":
            path.write_text(svg(), encoding="utf-8")
        else:
            image().save(path)
    except (OSError, ValueError) as error:  # ValueError: an unknown file extension
        reason = getattr(error, "strerror", None) or error
        raise FlatlandError(f"{path}: cannot be written: {reason}") from None


def to_array(image: Image.Image) -> UInt8Array:
    """Red, green and blue of an image: shape (height, width, 3); a new array."""
    return np.array(image)


def to_png(image: Image.Image) -> bytes:
    """The contents of a PNG file."""
    file = io.BytesIO()
    image.save(file, "PNG")
    return file.getvalue()


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

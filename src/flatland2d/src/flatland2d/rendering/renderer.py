"""Draws a world, into an image or a file."""

import io
import math
from pathlib import Path
from typing import Iterable, Optional, Union

import numpy as np
from PIL import Image

from flatland2d.rendering import scene
from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.rendering.svg_canvas import SvgCanvas
from flatland2d.rendering.tiles import Tiles
from flatland2d.rendering.view import Size, View, fitting_size
from flatland_server.arrays import UInt8Array
from flatland_server.canvas import Canvas, Points
from flatland_server.exceptions import FlatlandError
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
        if not (math.isfinite(width) and width > 0.0):
            raise FlatlandError(f"expected a width above 0 m, found {width}")
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
    path: Union[str, Path],
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
    path = Path(path)
    try:
        if path.suffix.lower() == ".svg":
            document = renderer.svg(view, sensors=sensors, names=names, trails=trails)
            path.write_text(document, encoding="utf-8")
        else:
            renderer.image(view, sensors=sensors, names=names, trails=trails).save(path)
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

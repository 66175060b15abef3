"""Pictures one after the other, and side by side, as a notebook shows them."""

import io
import math
import os
from typing import List, Sequence, Union

import numpy as np
from PIL import Image

from flatland2d.rendering.renderer import to_png
from flatland_server.arguments import shown
from flatland_server.arrays import UInt8Array
from flatland_server.exceptions import FlatlandError, UsageError

_GAP = 4
"""Between pictures side by side [pixels]."""


class Animation:
    """Pictures of a run, which a notebook plays.

        film = Animation(fps=20)
        for _ in range(100):
            film.add(sim.step(10).render((480, 360), follow="robot"))
        film                       # the last line of a cell; or film.save("run.gif")

    Args:
        fps: pictures per second at which it is played.

    Raises:
        UsageError: the rate is not above zero.
    """

    def __init__(self, fps: float = 20.0) -> None:
        if isinstance(fps, bool) or not isinstance(fps, (int, float)) or not 0.0 < fps < math.inf:
            raise UsageError(f"expected a rate above 0, found {shown(fps)}")
        self._fps = fps
        self._pictures: List[Image.Image] = []

    def add(self, picture: UInt8Array) -> None:
        """Adds a picture.

        Args:
            picture: shape (height, width, 3) of uint8, the same for all; as `Simulation.render` and
                environments give it.

        Raises:
            UsageError: it has another shape or type.
        """
        is_picture = isinstance(picture, np.ndarray) and picture.dtype == np.uint8
        if not is_picture or picture.ndim != 3 or picture.shape[2] != 3 or not picture.size:
            raise UsageError(
                f"expected a picture as uint8 of shape (h, w, 3), found {picture!r:.60}"
            )
        image = Image.fromarray(picture)
        if self._pictures and image.size != self._pictures[0].size:
            raise UsageError(
                f"expected a picture of {self._pictures[0].size} pixels, found {image.size}"
            )
        self._pictures.append(image)

    def __len__(self) -> int:
        return len(self._pictures)

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes a file that plays again and again.

        Args:
            path: ends with .gif, .png (APNG) or .webp.

        Raises:
            FlatlandError: there are no pictures, or the file cannot be written.
        """
        suffix = os.path.splitext(os.fspath(path))[1].lower()
        if suffix not in (".gif", ".png", ".webp"):
            raise UsageError(f"expected a file .gif, .png or .webp, found {shown(os.fspath(path))}")
        content = self._encoded(suffix[1:])
        try:
            with open(path, "wb") as file:
                file.write(content)
        except OSError as error:
            raise FlatlandError(f"{path}: cannot be written: {error.strerror}") from None

    def _encoded(self, kind: str) -> bytes:
        if not self._pictures:
            raise UsageError("expected pictures: the animation is empty")
        first, *others = self._pictures
        content = io.BytesIO()
        duration = round(1000 / self._fps)  # ms
        first.save(content, kind, save_all=True, append_images=others, duration=duration, loop=0)
        return content.getvalue()

    def _repr_png_(self) -> bytes:
        """The film as browsers play it, an APNG."""
        return self._encoded("png")


def side_by_side(pictures: Sequence[UInt8Array]) -> bytes:
    """A PNG of pictures of the same size, in rows, with white lines between them."""
    columns = math.ceil(math.sqrt(len(pictures)))
    height, width = (size + _GAP for size in pictures[0].shape[:2])
    rows = math.ceil(len(pictures) / columns)
    sheet = Image.new("RGB", (columns * width - _GAP, rows * height - _GAP), "white")
    for index, picture in enumerate(pictures):
        row, column = divmod(index, columns)
        sheet.paste(Image.fromarray(picture), (column * width, row * height))
    return to_png(sheet)

"""From a map image to wall segments, as array operations.

A pixel is bright or dark; beyond the image's border everything is bright. A segment lies between
two neighbouring pixels that differ, and collinear segments that touch are one. The bottom left
corner of the image is the layer's origin.
"""

from typing import Tuple

import numpy as np
from PIL import Image

from flatland_server.arrays import BoolArray, IntArray, Segments


def bright_pixels(image: Image.Image, occupied_thresh: float) -> BoolArray:
    """Which pixels are brighter than the threshold: shape (height, width), the top row first.

    Args:
        image: of any mode; colours count by their luminance, and alpha does not count.
        occupied_thresh: between 0 (black) and 1 (white).
    """
    if image.mode in ("I", "I;16", "I;16B", "I;16L", "I;16N"):
        grey = np.asarray(image, dtype=np.float64) / 65535.0
    elif image.mode == "F":
        grey = np.asarray(image, dtype=np.float64) / 255.0
    elif image.mode == "1":
        grey = np.asarray(image, dtype=np.float64)
    else:
        grey = np.asarray(image.convert("RGB").convert("L"), dtype=np.float64) / 255.0
    return np.asarray(grey > occupied_thresh)


def outlines(bright: BoolArray) -> Segments:
    """The boundaries between bright and dark pixels, in pixels from the bottom left corner.

    Args:
        bright: shape (height, width), the top row first.
    """
    height = bright.shape[0]
    padded = np.pad(bright, 1, constant_values=True)
    # Entry (i, j): whether the line above row i of the image is a boundary along column j.
    row, first, last = _runs((padded[1:, :] != padded[:-1, :])[:, 1:-1])
    horizontal = np.column_stack([first, height - row, last, height - row])
    # The same for the line left of column j along row i, with rows and columns exchanged.
    column, top, bottom = _runs((padded[:, 1:] != padded[:, :-1])[1:-1, :].T)
    vertical = np.column_stack([column, height - bottom, column, height - top])
    return _near_ones_together(np.concatenate([horizontal, vertical]).astype(np.float64))


def _runs(lines: BoolArray) -> Tuple[IntArray, IntArray, IntArray]:
    """Runs of true values in each row: their rows, first indices, and indices past the last."""
    edges = np.diff(np.pad(lines, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, first = np.nonzero(edges == 1)
    last = np.nonzero(edges == -1)[1]
    return row, first, last


def _near_ones_together(segments: Segments, tile: float = 32.0) -> Segments:
    """Ordered tile by tile (of 32 pixels), so that Box2D's tree of edges is built well."""
    middle = (segments[:, :2] + segments[:, 2:]) / 2 // tile
    return np.asarray(segments[np.lexsort((middle[:, 0], middle[:, 1]))])

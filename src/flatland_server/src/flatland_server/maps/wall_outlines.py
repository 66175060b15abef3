"""Wall segments from a map image, by operations on arrays.

A pixel is bright or dark; outside the image everything is bright. A wall is the edge between a
bright and a dark pixel; collinear edges that touch are one segment. The bottom left corner of the
image is the origin of the layer.
"""

from typing import TYPE_CHECKING, Optional, Tuple

import numpy as np

from flatland_server.arrays import BoolArray, Int32Array, IntArray, Segments

if TYPE_CHECKING:  # Pillow is imported when an image is read
    from PIL import Image


def bright_pixels(image: "Image.Image", occupied_thresh: float) -> BoolArray:
    """The mask of pixels brighter than a threshold.

    Args:
        image: of any mode; colours are converted to their luminance, alpha is ignored.
        occupied_thresh: grey value between 0 (black) and 1 (white).

    Returns:
        Shape (height, width), the top row first.
    """
    if image.mode in ("I", "I;16", "I;16B", "I;16L", "I;16N"):
        grey = np.asarray(image, dtype=np.float64) / 65535.0
    elif image.mode == "F":
        grey = np.asarray(image, dtype=np.float64) / 255.0
    elif image.mode == "1":
        grey = np.asarray(image, dtype=np.float64)
    else:
        is_bright = np.arange(256) / 255.0 > occupied_thresh
        return np.asarray(is_bright[np.asarray(image.convert("RGB").convert("L"))])
    return np.asarray(grey > occupied_thresh)


def transparent_pixels(image: "Image.Image") -> Optional[BoolArray]:
    """The mask of pixels that are wholly transparent; None if the image has no alpha.

    Returns:
        Shape (height, width), the top row first.
    """
    if "A" not in image.mode and "transparency" not in image.info:
        return None
    colors = image if "A" in image.mode else image.convert("RGBA")
    return np.asarray(np.asarray(colors.getchannel("A")) == 0)


def outlines(bright: BoolArray) -> Segments:
    """The edges between bright and dark pixels.

    Args:
        bright: shape (height, width), the top row first.

    Returns:
        Segments in pixels from the bottom left corner: shape (n, 4), x1, y1, x2, y2.
    """
    height = bright.shape[0]
    padded = np.pad(bright, 1, constant_values=True)
    # Element (i, j): whether the upper side of the pixel in row i and column j is an edge.
    row, first, last = _runs((padded[1:, :] != padded[:-1, :])[:, 1:-1])
    horizontal = first, height - row, last, height - row
    # Element (j, i): the same for the left side of that pixel.
    column, top, bottom = _runs((padded[:, 1:] != padded[:, :-1])[1:-1, :].T)
    vertical = column, height - bottom, column, height - top
    coordinates = [np.concatenate(pair) for pair in zip(horizontal, vertical)]
    order = _by_tile(*coordinates)
    segments = np.empty((len(order), 4))
    for i, values in enumerate(coordinates):
        segments[:, i] = values[order]
    return segments


def _runs(lines: BoolArray) -> Tuple[Int32Array, Int32Array, Int32Array]:
    """Runs of true values in each row: their rows, first indices, and indices after the last."""
    edges = np.diff(np.pad(lines, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, first = (indices.astype(np.int32) for indices in np.nonzero(edges == 1))
    last = np.nonzero(edges == -1)[1].astype(np.int32)
    return row, first, last


def _by_tile(
    x1: Int32Array, y1: Int32Array, x2: Int32Array, y2: Int32Array, tile: int = 32
) -> IntArray:
    """The order of segments by square tiles [px]: then Box2D builds a balanced tree of edges."""
    column, row = (x1 + x2) // (2 * tile), (y1 + y2) // (2 * tile)
    return np.asarray(np.lexsort((column, row)))

"""Outlines of images: walls are between bright and dark pixels, and nowhere else."""

from typing import List, Set, Tuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as st_numpy
from PIL import Image

from flatland_server.maps.wall_outlines import bright_pixels, outlines

Point = Tuple[int, int]
Segment = Tuple[Point, Point]

BITMAPS = st_numpy.arrays(bool, st.tuples(st.integers(1, 7), st.integers(1, 7)))
WIDE_BITMAPS = st_numpy.arrays(bool, st.tuples(st.integers(1, 3), st.integers(30, 80)))


def walls(bright: np.ndarray) -> List[Segment]:
    """The outlines as pairs of points, the lower left one first, sorted."""
    rows = outlines(bright).tolist()
    assert all(value == int(value) for row in rows for value in row)
    return sorted(
        tuple(sorted([(int(x1), int(y1)), (int(x2), int(y2))])) for x1, y1, x2, y2 in rows
    )


def edges_between_different_pixels(bright: np.ndarray) -> Set[Segment]:
    """All edges of length 1 between different pixels, by brute force; the outside is bright."""
    height, width = bright.shape

    def is_bright(column: int, row: int) -> bool:
        inside = 0 <= column < width and 0 <= row < height
        return bool(bright[row, column]) if inside else True

    edges = set()
    for row in range(height + 1):
        for column in range(width + 1):
            y = height - row  # of the upper side of this row
            if is_bright(column, row) != is_bright(column, row - 1):
                edges.add(((column, y), (column + 1, y)))
            if is_bright(column, row) != is_bright(column - 1, row):
                edges.add(((column, y - 1), (column, y)))
    return edges


def unit_edges(segments: List[Segment]) -> List[Segment]:
    """Segments cut into pieces of one pixel."""
    pieces = []
    for (x1, y1), (x2, y2) in segments:
        assert (x1 == x2) != (y1 == y2)
        pieces += [((x, y1), (x + 1, y1)) for x in range(x1, x2)]
        pieces += [((x1, y), (x1, y + 1)) for y in range(y1, y2)]
    return pieces


@given(BITMAPS | WIDE_BITMAPS)
def test_walls_lie_exactly_between_different_pixels(bright):
    pieces = unit_edges(walls(bright))

    assert set(pieces) == edges_between_different_pixels(bright)
    assert len(pieces) == len(set(pieces))


@given(BITMAPS | WIDE_BITMAPS)
def test_collinear_walls_that_touch_are_one(bright):
    for axis in (0, 1):  # vertical walls share an x, horizontal ones a y
        along = [wall for wall in walls(bright) if wall[0][axis] == wall[1][axis]]
        ends = [end for wall in along for end in wall]
        assert len(ends) == len(set(ends))


def row(values: List[int], mode: str = "L", dtype: type = np.uint8) -> Image.Image:
    """A row of pixels."""
    return Image.fromarray(np.array([values], dtype=dtype), mode)


def colors(mode: str, *pixels: Tuple[int, ...]) -> Image.Image:
    """A row of pixels of several channels."""
    image = Image.new(mode, (len(pixels), 1))
    image.putdata(pixels)
    return image


def palette() -> Image.Image:
    """White, black and light grey."""
    image = row([0, 1, 2], "P")
    image.putpalette([255, 255, 255, 0, 0, 0, 200, 200, 200])
    return image


W, B = (255,) * 3, (0,) * 3


@pytest.mark.parametrize(
    ("image", "threshold", "expected"),
    [
        *((row([b - 1, b]), t, [0, 1]) for t, b in ((0.65, 166), (0.5, 128), (0, 1), (0.196, 50))),
        # Of 16 bits: 0.65 * 65535 = 42597.75
        (row([0, 255, 42597, 42598, 65535], "I;16", np.uint16), 0.65, [0, 0, 0, 1, 1]),
        (palette(), 0.65, [1, 0, 1]),
        (row([0, 255]).convert("1"), 0.65, [0, 1]),
        # Alpha is ignored.
        (colors("RGBA", (*W, 255), (*W, 0), (*B, 255), (*B, 0)), 0.65, [1, 1, 0, 0]),
        (colors("LA", (255, 255), (255, 0), (0, 255), (0, 0)), 0.65, [1, 1, 0, 0]),
        # ITU-R 601: 0.299 R + 0.587 G + 0.114 B; green alone is brighter than half
        (colors("RGB", (255, 0, 0), (0, 255, 0), (0, 0, 255)), 0.5, [0, 1, 0]),
    ],
)
def test_pixels_are_bright_above_the_threshold(tmp_path, image, threshold, expected):
    image.save(tmp_path / "map.png")
    opened = Image.open(tmp_path / "map.png")

    assert opened.mode[0] == image.mode[0]
    assert bright_pixels(opened, threshold).tolist() == [[bool(each) for each in expected]]

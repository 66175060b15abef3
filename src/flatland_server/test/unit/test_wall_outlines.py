"""Outlines of images: walls are between bright and dark pixels, and nowhere else."""

from pathlib import Path
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


def saved_and_opened(image: Image.Image, folder: Path) -> Image.Image:
    """An image that was saved and opened again."""
    image.save(folder / "map.png")
    return Image.open(folder / "map.png")


def image_of(values: List[int], mode: str, dtype: type = np.uint8) -> Image.Image:
    """A row of pixels."""
    return Image.fromarray(np.array([values], dtype=dtype), mode)


@pytest.mark.parametrize(
    ("threshold", "darkest_bright"), [(0.65, 166), (0.5, 128), (0.0, 1), (0.196, 50)]
)
def test_a_pixel_is_bright_above_the_threshold_times_255(tmp_path, threshold, darkest_bright):
    image = saved_and_opened(image_of([darkest_bright - 1, darkest_bright], "L"), tmp_path)

    assert bright_pixels(image, threshold).tolist() == [[False, True]]


def test_the_threshold_of_a_16_bit_image_is_relative_to_65535(tmp_path):
    # 0.65 * 65535 = 42597.75
    grey = image_of([0, 255, 42597, 42598, 65535], "I;16", np.uint16)
    image = saved_and_opened(grey, tmp_path)

    assert image.mode.startswith("I")
    assert bright_pixels(image, 0.65).tolist() == [[False, False, False, True, True]]


def test_a_palette_image_is_read_by_its_colours(tmp_path):
    palette = image_of([0, 1, 2], "P")
    palette.putpalette([255, 255, 255, 0, 0, 0, 200, 200, 200])
    image = saved_and_opened(palette, tmp_path)

    assert image.mode == "P"
    assert bright_pixels(image, 0.65).tolist() == [[True, False, True]]


@pytest.mark.parametrize("mode", ["RGBA", "LA"])
def test_alpha_is_ignored(tmp_path, mode):
    image = Image.new(mode, (4, 1))
    white, black = (255,) * (len(mode) - 1), (0,) * (len(mode) - 1)
    image.putdata([(*white, 255), (*white, 0), (*black, 255), (*black, 0)])

    opened = saved_and_opened(image, tmp_path)

    assert opened.mode == mode
    assert bright_pixels(opened, 0.65).tolist() == [[True, True, False, False]]


def test_a_1_bit_image_is_black_and_white(tmp_path):
    image = saved_and_opened(image_of([0, 255], "L").convert("1"), tmp_path)

    assert image.mode == "1"
    assert bright_pixels(image, 0.65).tolist() == [[False, True]]


def test_colours_are_converted_to_their_luminance(tmp_path):
    # ITU-R 601: 0.299 R + 0.587 G + 0.114 B; green alone is brighter than half
    image = Image.new("RGB", (3, 1))
    image.putdata([(255, 0, 0), (0, 255, 0), (0, 0, 255)])

    assert bright_pixels(saved_and_opened(image, tmp_path), 0.5).tolist() == [[False, True, False]]

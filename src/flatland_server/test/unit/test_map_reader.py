"""Map files: walls from images and line segments, scaled and placed in the world."""

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from flatland_server.maps.map_reader import MapConfig

ONE_PIXEL = {((1, 1), (2, 1)), ((1, 2), (2, 2)), ((1, 1), (1, 2)), ((2, 1), (2, 2))}
"""The walls around the dark middle of 3 x 3 pixels, in pixels."""


@pytest.fixture
def maps(files):
    """An image map of one dark pixel in the middle of 3 x 3, and the data of a wall of 1 m."""
    pixels = np.full((3, 3), 255, dtype=np.uint8)
    pixels[1, 1] = 0
    Image.fromarray(pixels).save(files.folder / "map.png")
    files.write("map.yaml", image_map())
    files.write("wall.dat", "0 0 1 0\n")
    return files


def image_map(resolution: float = 1.0, origin: str = "[0, 0, 0]", more: str = "") -> str:
    """A map file for the image map.png."""
    return (
        f"image: map.png\nresolution: {resolution}\norigin: {origin}\n"
        f"occupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n{more}"
    )


def segment_map(scale: float = 1.0, origin: str = "[0, 0, 0]") -> str:
    """A map file for the line segments wall.dat."""
    return f"type: line_segments\ndata: wall.dat\nscale: {scale}\norigin: {origin}\n"


def walls(path: Path, digits: int = 9) -> set:
    """The walls of a map as a set of pairs of rounded points."""
    rows = np.round(MapConfig.from_file(path).walls(), digits) + 0.0
    return {tuple(sorted([(x1, y1), (x2, y2)])) for x1, y1, x2, y2 in rows.tolist()}


@pytest.mark.parametrize(
    ("options", "place"),
    [
        ({"resolution": 0.5}, lambda x, y: (x / 2, y / 2)),
        ({"origin": "[-10, 20, 0]"}, lambda x, y: (x - 10, y + 20)),
        # A quarter turn counter-clockwise takes (x, y) to (-y, x).
        ({"origin": f"[5, 7, {math.pi / 2}]"}, lambda x, y: (5 - y, 7 + x)),
    ],
)
def test_an_image_is_scaled_and_its_corner_lies_at_the_origin(maps, options, place):
    path = maps.write("map.yaml", image_map(**options))

    assert walls(path) == {tuple(sorted((place(*a), place(*b)))) for a, b in ONE_PIXEL}


@pytest.mark.parametrize(
    "data",
    [
        b"\xef\xbb\xbf0 0 1 1\r\n2 3 -1 2\r\n",  # of Windows
        b"# file: wall.dat\n0 0 1 1  # a wall\n  # indented\n2 3 -1 2#\n",
    ],
)
def test_line_segments_may_have_windows_line_ends_and_comments(files, data):
    (files.folder / "wall.dat").write_bytes(data)
    path = files.write("wall.yaml", segment_map())

    assert MapConfig.from_file(path).walls().tolist() == [[0, 0, 1, 1], [2, 3, -1, 2]]


def test_the_yaml_file_is_read_without_the_image_that_it_names(maps):
    maps.write("map.png", "not an image")

    config = MapConfig.from_file(maps.folder / "map.yaml")

    assert config.source == maps.folder / "map.png"
    assert (config.is_image, config.scale, config.occupied_thresh) == (True, 1.0, 0.65)


@pytest.mark.parametrize(
    ("kind", "is_told"), [("indoor", False), ("private", False), ("line_segment", True)]
)
def test_an_unknown_map_type_is_read_as_an_image(maps, caplog, kind, is_told):
    caplog.set_level("INFO")
    path = maps.write("map.yaml", image_map(more=f"type: {kind}\n"))

    assert walls(path) == ONE_PIXEL
    told = f'{path}: read as an image: expected "line_segments", found "{kind}"'
    assert (told in [record.getMessage() for record in caplog.records]) == is_told

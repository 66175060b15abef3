"""Line segments from a map of map_server."""

import numpy as np
import pytest
from PIL import Image, ImageDraw

from flatland_server import FlatlandError, YamlError
from flatland_server.maps.line_map import LineMap
from flatland_server.maps.map_reader import MapConfig

MAP = "image: room.png\nresolution: 0.05\norigin: [-1.5, 2.25, 0.3]\noccupied_thresh: 0.65\n"


@pytest.fixture
def room(tmp_path):
    """A map of a room with an oblique wall; returns its folder."""
    image = Image.new("L", (80, 60), 254)
    draw = ImageDraw.Draw(image)
    draw.rectangle([5, 5, 74, 54], outline=0, width=2)
    draw.line([10, 10, 60, 45], fill=0, width=3)
    draw.rectangle([40, 10, 60, 20], fill=205)  # unknown
    image.save(tmp_path / "room.png")
    (tmp_path / "room.yaml").write_text(MAP + "free_thresh: 0.196\nnegate: 0\n")
    return tmp_path


def directionless(segments):
    return {frozenset([tuple(row[:2]), tuple(row[2:])]) for row in segments.tolist()}


def test_without_a_tolerance_the_layer_is_that_of_the_image(room):
    line_map = LineMap.from_file(room / "room.yaml", tolerance=0.0)
    data = line_map.write(room / "lines.yaml")

    assert data == room / "lines.dat"
    assert line_map.deviation == 0.0
    assert directionless(MapConfig.from_file(room / "lines.yaml").walls()) == directionless(
        MapConfig.from_file(room / "room.yaml").walls()
    )


def test_lines_are_fewer_and_within_the_tolerance(room):
    line_map = LineMap.from_file(room / "room.yaml", tolerance=0.05)
    line_map.write(room / "lines.yaml")

    assert len(line_map.lines) < len(line_map.outlines) / 3
    assert 0.0 < line_map.deviation <= 0.05
    np.testing.assert_array_equal(
        MapConfig.from_file(room / "lines.yaml").walls(), line_map.in_world(line_map.lines)
    )
    assert len(LineMap.from_file(room / "room.yaml").lines) == len(line_map.lines)  # one pixel


def test_negate_makes_white_the_walls(room):
    expected = LineMap.from_file(room / "room.yaml")
    image = Image.open(room / "room.png")
    image.point([255 - value for value in range(256)]).save(room / "room.png")
    (room / "room.yaml").write_text(MAP + "negate: 1\n")

    np.testing.assert_array_equal(LineMap.from_file(room / "room.yaml").lines, expected.lines)


def test_the_threshold_is_that_of_occupancy(room):
    Image.new("L", (9, 9), 128).save(room / "room.png")  # occupancy 0.498

    def count(threshold):
        (room / "room.yaml").write_text(MAP.replace("0.65", threshold))
        return len(LineMap.from_file(room / "room.yaml").outlines)

    assert (count("0.49"), count("0.5")) == (4, 0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (MAP + "negat: 1\n", 'unknown key "negat" (did you mean "negate"?)'),
        (MAP + "mode: raw\n", "trinary"),
        (MAP.replace("0.05", "0"), "resolution"),
        (MAP.replace("room.png", "none.png"), "none.png"),
    ],
)
def test_a_wrong_map_file_is_refused(room, text, expected):
    (room / "room.yaml").write_text(text)
    with pytest.raises(YamlError) as error:
        LineMap.from_file(room / "room.yaml")
    assert expected in str(error.value)
    assert "room.yaml" in str(error.value)


def test_a_file_that_cannot_be_written_is_an_error(room):
    line_map = LineMap.from_file(room / "room.yaml")
    with pytest.raises(FlatlandError, match=r"lines\.dat: cannot be written: No such file"):
        line_map.write(room / "nowhere" / "lines.yaml")

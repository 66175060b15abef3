"""Layers: walls out of images and line segments, placed, scaled and named."""

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from flatland_server import _core
from flatland_server.exceptions import YamlError
from flatland_server.models.layer import read_map
from flatland_server.timekeeper import Timekeeper

ONE_PIXEL = {((1, 1), (2, 1)), ((1, 2), (2, 2)), ((1, 1), (1, 2)), ((2, 1), (2, 2))}
"""The walls around the dark middle of 3 x 3 pixels, in pixels."""


@pytest.fixture
def maps(files):
    """A folder with an image map of one dark pixel in the middle of 3 x 3, and a wall of 1 m."""
    pixels = np.full((3, 3), 255, dtype=np.uint8)
    pixels[1, 1] = 0
    Image.fromarray(pixels).save(files.folder / "map.png")
    files.write("map.yaml", image_map())
    files.write("wall.dat", "0 0 1 0\n")
    files.write("wall.yaml", segment_map())
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


def world(*layers: str) -> str:
    """A world file of these layers."""
    entries = "".join(f"\n  - {layer}" for layer in layers)
    return f"properties: {{}}\nlayers:{entries or ' []'}\n"


def place(path: Path, digits: int = 9) -> set:
    """A map's walls as a set of pairs of rounded points."""
    rows = np.round(read_map(path), digits) + 0.0
    return {tuple(sorted([(x1, y1), (x2, y2)])) for x1, y1, x2, y2 in rows.tolist()}


def refusal(files, path: Path) -> str:
    """Why a map is not read, without the folder's name."""
    with pytest.raises(YamlError) as caught:
        read_map(path)
    return str(caught.value).replace(f"{files.folder}/", "")


def test_resolution_scales_an_image(maps):
    path = maps.write("map.yaml", image_map(resolution=0.5))

    assert place(path) == {
        tuple(sorted(((x1 / 2, y1 / 2), (x2 / 2, y2 / 2)))) for (x1, y1), (x2, y2) in ONE_PIXEL
    }


def test_the_origin_is_where_the_bottom_left_corner_lies(maps):
    path = maps.write("map.yaml", image_map(origin="[-10, 20, 0]"))

    assert place(path) == {
        tuple(sorted(((x1 - 10, y1 + 20), (x2 - 10, y2 + 20)))) for (x1, y1), (x2, y2) in ONE_PIXEL
    }


def test_the_origins_yaw_turns_the_map_about_its_corner(maps):
    # A quarter turn counter-clockwise takes (x, y) to (-y, x).
    path = maps.write("map.yaml", image_map(origin=f"[5, 7, {math.pi / 2}]"))

    assert place(path) == {
        tuple(sorted(((5 - y1, 7 + x1), (5 - y2, 7 + x2)))) for (x1, y1), (x2, y2) in ONE_PIXEL
    }


def test_line_segments_are_scaled_turned_and_moved(files):
    files.write("wall.dat", "0    0    1    1\n\n2    3   -1    2\n")
    path = files.write("wall.yaml", segment_map(scale=0.1, origin="[-1.2, -5, 1.23]"))

    [first, second] = read_map(path).tolist()

    cos, sin = math.cos(1.23), math.sin(1.23)
    assert first == pytest.approx([-1.2, -5, -1.2 + 0.1 * (cos - sin), -5 + 0.1 * (sin + cos)])
    assert second[:2] == pytest.approx(
        [-1.2 + 0.2 * cos - 0.3 * sin, -5 + 0.2 * sin + 0.3 * cos], abs=1e-12
    )
    assert second[2:] == pytest.approx(
        [-1.2 - 0.1 * cos - 0.2 * sin, -5 - 0.1 * sin + 0.2 * cos], abs=1e-12
    )


def test_paths_are_relative_to_the_file_that_names_them(files):
    (files.folder / "maps").mkdir()
    (files.folder / "maps" / "data").mkdir()
    files.write("maps/data/wall.dat", "0 0 0 1")
    files.write("maps/wall.yaml", segment_map().replace("wall.dat", "data/wall.dat"))

    loaded = files.load(world("{name: a, map: maps/wall.yaml}"))

    assert loaded.layers[0].segments.tolist() == [[0, 0, 0, 1]]


def test_an_absolute_path_stays_as_it_is(files, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "wall.dat").write_text("0 0 0 1")
    (elsewhere / "wall.yaml").write_text(segment_map())

    loaded = files.load(world(f"{{name: a, map: {elsewhere}/wall.yaml}}"))

    assert len(loaded.layers[0].segments) == 1


def test_walls_of_a_layer_stand_in_the_physical_world(maps):
    loaded = maps.load(world("{name: a, map: map.yaml}"))

    ranges, _ = loaded.physics.scan(_core.BeamFan(0.0, 1.0, 1), (0.0, 1.5, 0.0), 5.0)

    assert ranges.tolist() == pytest.approx([1.0])


def test_all_names_of_a_layer_are_collision_layers_and_the_first_identifies_it(maps):
    loaded = maps.load(world("{name: [a, b], map: wall.yaml}", "{name: c}"))

    assert [layer.name for layer in loaded.layers] == ["a", "c"]
    down = (0.5, 1.0, -math.pi / 2)
    for name, seen in {"a": 1.0, "b": 1.0, "c": math.inf}.items():
        bits = loaded.registry.bits([name])
        ranges, _ = loaded.physics.scan(_core.BeamFan(0.0, 1.0, 1), down, 5.0, layers=bits)
        assert ranges.tolist() == pytest.approx([seen])


def test_sixteen_names_fit_and_seventeen_do_not(files):
    def named(count: int) -> str:
        return world("{name: first}", f"{{name: [{', '.join(f'n{i}' for i in range(1, count))}]}}")

    loaded = files.load(named(16))

    assert loaded.registry.bits(["n15"]) == 1 << 15
    assert files.refusal(named(17)) == (
        "world.yaml:4: layers[1].name: expected at most 16 layer names in all, found more"
    )


def test_a_layer_without_a_map_has_no_walls_but_footprints_may_name_it(files):
    files.write(
        "two.model.yaml",
        """
        bodies:
          - name: left
            pose: [-1, 0, 0]
            footprints: [{type: circle, radius: 0.5, density: 1, layers: [nothing]}]
          - name: right
            pose: [1, 0, 0]
            footprints: [{type: circle, radius: 0.5, density: 1, layers: [nothing]}]
        """,
    )
    loaded = files.load(
        world("{name: nothing}") + "models:\n  - {name: two, model: two.model.yaml}"
    )
    left, right = (loaded.models["two"].get_body(name) for name in ("left", "right"))
    left.physics_body.velocity = (1.0, 0.0, 0.0)

    timekeeper = Timekeeper(0.01)
    for _ in range(200):
        loaded.step(timekeeper)

    assert len(loaded.layers[0].segments) == 0
    assert right.pose.x > 1.2
    assert left.pose.x < right.pose.x - 0.98


@pytest.mark.parametrize(
    ("layers", "message"),
    [
        pytest.param(
            ["{name: a}", "{name: [b, a]}"],
            '4: layers[1].name: the layer name "a" is given twice',
            id="a name given twice",
        ),
        pytest.param(
            ["{name: all}"],
            '3: layers[0].name: the name "all" stands for all layers',
            id="the reserved name",
        ),
        pytest.param(
            ["{name: []}"],
            "3: layers[0].name: expected a name or a list of names, found an empty list",
            id="no name",
        ),
        pytest.param(
            ["{name: ''}"],
            "3: layers[0].name: expected a name, found an empty one",
            id="an empty name",
        ),
        pytest.param(
            ["{name: ground floor}"],
            '3: layers[0].name: expected a name of letters, digits and "_" (it names a ROS topic), '
            'found "ground floor"',
            id="a name with a space",
        ),
        pytest.param(
            ["{map: wall.yaml}"],
            '3: layers[0]: the required key "name" is missing',
            id="name missing",
        ),
        pytest.param(
            ["{name: a, mapp: wall.yaml}"],
            '3: layers[0] "a": unknown key "mapp" (did you mean "map"?)',
            id="unknown key",
        ),
        pytest.param(
            ["{name: a, properties: {debug: {min: 1}}}"],
            '3: layers[0].properties.debug: unknown key "min" (did you mean "min_z"?)',
            id="unknown key in debug",
        ),
        pytest.param(
            ["{name: a, properties: {debgu: {min_z: 1}}}"],
            '3: layers[0].properties: unknown key "debgu" (did you mean "debug"?)',
            id="unknown key in properties",
        ),
        pytest.param(
            ["{name: a, color: [1, 1, 1]}"],
            "3: layers[0].color: expected [r, g, b, alpha], found [1, 1, 1]",
            id="a short colour",
        ),
    ],
)
def test_a_wrong_layer_is_refused_at_its_line(maps, layers, message):
    assert maps.refusal(world(*layers)) == f"world.yaml:{message}"


def test_a_map_that_is_not_there_is_named_where_it_is_written(files):
    message = files.refusal(world("{name: a}", "{name: b, map: nowhere.yaml}"))

    assert message == "world.yaml:4: layers[1].map: expected a file, but nowhere.yaml is not there"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        pytest.param(
            image_map(more="occupied_tresh: 0.5\n"),
            '7: unknown key "occupied_tresh"',
            id="unknown key of an image map",
        ),
        pytest.param(
            image_map(resolution=0.0),
            "2: resolution: expected a number above 0, found 0.0",
            id="no resolution",
        ),
        pytest.param(
            image_map(origin="[0, 0]"),
            "3: origin: expected [x, y, yaw], found [0, 0]",
            id="origin without yaw",
        ),
        pytest.param(
            "image: map.png\nresolution: 1\noccupied_thresh: 0.5\n",
            '1: the required key "origin" is missing',
            id="origin missing",
        ),
        pytest.param(
            "image: map.png\nresolution: 1\norigin: [0, 0, 0]\n",
            '1: the required key "occupied_thresh" is missing',
            id="threshold missing",
        ),
        pytest.param(
            segment_map(scale=-1.0),
            "3: scale: expected a number above 0, found -1.0",
            id="negative scale",
        ),
        pytest.param(
            segment_map() + "resolution: 1\n",
            '5: unknown key "resolution"',
            id="an image's key for line segments",
        ),
        pytest.param(
            segment_map().replace("line_segments", "line_segment"),
            '1: type: expected image or line_segments (did you mean "line_segments"?), '
            'found "line_segment"',
            id="unknown type",
        ),
    ],
)
def test_a_wrong_map_file_is_refused_at_its_line(maps, text, message):
    path = maps.write("any.yaml", text)

    assert refusal(maps, path) == f"any.yaml:{message}"


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("0 0 1", 'expected "x1 y1 x2 y2", found "0 0 1"'),
        ("0 0 1 1 1", 'expected "x1 y1 x2 y2", found "0 0 1 1 1"'),
        ("0, 0, 1, 1", 'expected "x1 y1 x2 y2", found "0, 0, 1, 1"'),
        ("0 0 nan 1", 'expected "x1 y1 x2 y2", found "0 0 nan 1"'),
        ("0 0 inf 1", 'expected "x1 y1 x2 y2", found "0 0 inf 1"'),
        ("1 2 1.0 2", "expected two different ends, found one point twice"),
    ],
)
def test_a_wrong_line_segment_is_named_with_its_file_and_line(files, line, problem):
    files.write("wall.dat", f"0 0 1 0\n\n{line}\n0 1 1 1\n")
    path = files.write("wall.yaml", segment_map())

    assert refusal(files, path) == f"wall.dat:3: {problem}"


def test_line_segments_that_are_not_there_are_named(files):
    path = files.write("wall.yaml", segment_map())

    assert refusal(files, path) == "wall.yaml:2: data: expected a file, but wall.dat is not there"


def test_an_image_that_is_not_there_is_named(files):
    path = files.write("map.yaml", image_map())

    assert refusal(files, path) == "map.yaml:1: image: expected a file, but map.png is not there"


def test_a_file_that_is_no_image_is_named(files):
    files.write("map.png", "a map")
    path = files.write("map.yaml", image_map())

    assert refusal(files, path) == "map.png: is not an image of a known format"


def test_an_image_cut_short_is_refused(maps):
    content = (maps.folder / "map.png").read_bytes()
    cut_in_its_pixels = content.index(b"IDAT") + 6
    (maps.folder / "map.png").write_bytes(content[:cut_in_its_pixels])

    message = refusal(maps, maps.folder / "map.yaml")

    assert message.startswith("map.png: cannot be read as an image: ")


@pytest.mark.parametrize(
    ("segments", "origin"),
    [
        pytest.param("0 0 1e6 0", "[0, 0, 0]", id="a wall of 1000 km"),
        pytest.param("0 0 1e-17 0", "[1, 0, 0]", id="a wall too short to be told from a point"),
    ],
)
def test_a_wall_that_physics_cannot_take_is_an_error_of_its_file(files, segments, origin):
    files.write("wall.dat", segments)
    files.write("wall.yaml", segment_map(origin=origin))

    message = files.refusal(world("{name: a, map: wall.yaml}"))

    assert any(name in message for name in ("wall.dat", "wall.yaml", "world.yaml:3: layers[0]"))

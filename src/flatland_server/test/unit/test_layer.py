"""Layers: their names, collision layers and walls."""

import math

import pytest
from PIL import Image

from flatland_server import _core
from flatland_server.simulation.run import Run
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.timekeeper import Timekeeper

LINES = "{type: line_segments, data: wall.dat, scale: 1, origin: [0, 0, 0]}"
IMAGE = "{image: map.png, resolution: 1, origin: [0, 0, 0], occupied_thresh: 0.65}"


@pytest.fixture
def maps(files):
    """A folder with a map of an image of one dark pixel at (1, 1), and one of a wall of 1 m."""
    image = Image.new("L", (3, 3), 255)
    image.putpixel((1, 1), 0)
    image.save(files.folder / "map.png")
    files.write("map.yaml", IMAGE)
    files.write("wall.dat", "0 0 1 0\n")
    files.write("wall.yaml", LINES)
    return files


def world(*layers: str) -> str:
    """A world file of these layers."""
    entries = "".join(f"\n  - {layer}" for layer in layers)
    return f"properties: {{}}\nlayers:{entries or ' []'}\n"


def test_each_name_of_a_layer_is_a_collision_layer(maps):
    loaded = maps.load(world("{name: [a, b], map: wall.yaml}", "{name: c}"))

    assert [layer.name for layer in loaded.layers] == ["a", "c"]
    down = (0.5, 1.0, -math.pi / 2)
    for name, seen in {"a": 1.0, "b": 1.0, "c": math.inf}.items():
        bits = loaded.registry.bits([name])
        ranges, _ = loaded.physics.scan(_core.BeamFan(0.0, 1.0, 1), down, 5.0, layers=bits)
        assert ranges.tolist() == pytest.approx([seen])


def test_images_and_grids_enclose_areas_but_lines_do_not(maps):
    grid = "{grid: [[0, 1]], resolution: 1}"
    loaded = maps.load(
        world("{name: a, map: map.yaml}", "{name: b, map: wall.yaml}", f"{{name: c, map: {grid}}}")
    )

    assert [layer.config.encloses for layer in loaded.layers] == [True, False, True]


def test_footprints_may_name_a_layer_without_a_map(files):
    disc = "{type: circle, radius: 0.5, density: 1, layers: [nothing]}"
    bodies = ", ".join(
        f"{{name: {name}, pose: [{x}, 0, 0], footprints: [{disc}]}}"
        for name, x in (("left", -1), ("right", 1))
    )
    files.write("two.model.yaml", f"bodies: [{bodies}]")
    loaded = files.load(
        world("{name: nothing}") + "models:\n  - {name: two, model: two.model.yaml}"
    )
    left, right = (loaded.models["two"].get_body(name) for name in ("left", "right"))
    left.physics_body.velocity = (1.0, 0.0, 0.0)

    Run(loaded, Timekeeper(0.01)).step(200)

    assert len(loaded.layers[0].segments) == 0
    assert right.pose.x > 1.2
    assert left.pose.x < right.pose.x - 0.98


def test_a_map_of_two_layers_is_read_once(maps):
    path = maps.write("world.yaml", world("{name: a, map: wall.yaml}", "{name: b, map: wall.yaml}"))

    config = WorldConfig.from_file(path)

    first, second = (config.walls_of(layer) for layer in config.layers)
    assert first is second
    assert first.tolist() == [[0, 0, 1, 0]]

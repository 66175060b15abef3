"""Maps that are in a world itself: from Python, and in files."""

import numpy as np
import pytest
from library.parts import room
from PIL import Image

from flatland2d import FlatlandError, Simulation, SimulationBatch, world_content
from flatland_server.testing import WorldFiles


def walls(map):
    with Simulation(room(map)) as simulation:
        return simulation.world.layers[0].segments


def scan(source):
    with Simulation(source) as simulation:
        simulation.models["robot"].command(0.5, 0.2)
        simulation.step(100)
        return simulation.models["robot"].sensors["laser"].read().tobytes()


def test_shapes_are_walls():
    triangle = [[1, 1], [2, 1], [1, 2]]
    found = walls({"segments": [[-4, -4, 4, -4]], "polygons": [triangle], "circles": [[0, 3, 0.5]]})

    assert found[:4].tolist() == [[-4, -4, 4, -4], [1, 1, 2, 1], [2, 1, 1, 2], [1, 2, 1, 1]]
    assert np.hypot(found[4:, 0], found[4:, 1] - 3) == pytest.approx(np.full(36, 0.5))
    assert np.array_equal(found[4:, 2:], np.roll(found[4:, :2], -1, axis=0))


def test_shapes_are_scaled_and_placed():
    rows = np.array([[0.0, 0, 10, 0]])
    found = walls({"segments": rows, "scale": 0.1, "origin": [1, 2, np.pi / 2]})
    assert found == pytest.approx(np.array([[1.0, 2, 1, 3]]))
    assert len(walls({"segments": []})) == 0


@pytest.mark.parametrize("kind", [bool, np.int8, float, list])
def test_a_grid_has_the_walls_of_its_picture(tmp_path, kind):
    occupied = np.random.default_rng(1).random((20, 30)) > 0.7
    files = WorldFiles(tmp_path)
    Image.fromarray(np.where(occupied[::-1], 0, 255).astype(np.uint8)).save(tmp_path / "map.png")
    yaml = "image: map.png\nresolution: 0.1\norigin: [-1, 1, 0.5]\noccupied_thresh: 0.5\n"
    path = files.write("map.yaml", yaml)

    grid = occupied.tolist() if kind is list else occupied.astype(kind)
    found = walls({"grid": grid, "resolution": 0.1, "origin": [-1, 1, 0.5]})

    assert found.tobytes() == walls(str(path)).tobytes()


def test_a_grid_may_have_probabilities_and_unknown_cells():
    grid = np.array([[-1, 0, 40], [100, 0, 60]])
    assert len(walls({"grid": grid, "resolution": 1})) == 8
    assert (
        walls({"grid": grid, "resolution": 1, "occupied_thresh": 50}).tolist()
        == walls({"grid": [[0, 0, 0], [1, 0, 1]], "resolution": 1}).tolist()
    )


def test_the_content_of_a_world_has_its_maps(tmp_path):
    for name in ("office", "test_room"):
        content = world_content(name)
        [layer] = content["layers"]
        with Simulation(name) as a, Simulation(content) as b:
            assert a.world.layers[0].segments.tobytes() == b.world.layers[0].segments.tobytes()
    layer["map"]["segments"][0] = [0, 0, 1, 1]  # an array of the caller's
    assert world_content("test_room")["layers"][0]["map"]["segments"][0].tolist() != [0, 0, 1, 1]


def test_files_may_have_such_maps_and_every_front_takes_them(tmp_path):
    files = WorldFiles(tmp_path)
    files.write(
        "room.yaml", "segments: [[-2, -2, 2, -2], [2, -2, 2, 2]]\ncircles: [[-2, 0, 0.3]]\n"
    )
    content = room({"segments": [[-2, -2, 2, -2], [2, -2, 2, 2]], "circles": [[-2, 0, 0.3]]})
    inside, outside = (
        files.write(f"{name}.yaml", {**content, "layers": [{"name": "map", "map": map}]})
        for name, map in (("inside", content["layers"][0]["map"]), ("outside", "room.yaml"))
    )

    assert scan(content) == scan(inside) == scan(outside) == scan(world_content(outside))
    with SimulationBatch(content, 2) as batch, Simulation(inside) as simulation:
        batch.step([[0.5, 0.2]] * 2, 60)
        simulation.models["robot"].command(0.5, 0.2)
        state = simulation.step(60).save_state()
        simulation.step(40)
        simulation.load_state(state)
        simulation.models["robot"].command(0.5, 0.2)
        simulation.step(40)
        ranges = batch.step([[0.5, 0.2]] * 2, 40).ranges[1]
        assert simulation.models["robot"].sensors["laser"].read().tobytes() == ranges.tobytes()
    assert ranges.tobytes() == scan(content)


@pytest.mark.parametrize(
    ("map", "message"),
    [
        ({}, 'map: expected a file, or one of "segments", "polygons", "circles", "grid"; found'),
        ({"segmants": []}, r'unknown key "segmants" \(did you mean "segments"'),
        ({"segments": [[1, 2, 3, 4], [1, 2, 3]]}, r"segments\[1\]: expected \[x1, y1, x2, y2\]"),
        ({"segments": np.full((2, 4), np.nan)}, r"map.segments\[0\]: expected \[x1, y1, x2, y2\]"),
        ({"segments": [[1, 1, 1, 1]]}, r"a micrometre or more, found a shorter one: \[1.0, 1.0"),
        ({"polygons": [[[0, 0], [1, 1]]]}, r"polygons\[0\]: expected a list of 3 or more points"),
        ({"circles": [[0, 0, 1], [0, 0, 0]]}, r"expected a radius above 0 in circles\[1\]"),
        ({"circles": [[0, 0, 1e7]]}, r"\[0\].map: expected walls within 100 km of the origin"),
        ({"grid": np.zeros((2, 2))}, 'the required key "resolution" is missing'),
        ({"grid": [[1, 0], [1]], "resolution": 1}, "expected rows of the same length"),
        ({"grid": [["a"]], "resolution": 1}, "expected rows of numbers"),
        ({"grid": np.zeros((2, 2, 2)), "resolution": 1}, "expected rows of numbers"),
        ({"grid": [[1]], "resolution": 1, "segments": []}, 'unknown key "segments"'),
    ],
)
def test_wrong_maps_are_refused_with_their_place(tmp_path, map, message):
    with pytest.raises(FlatlandError, match=message) as error:
        Simulation(room(map))
    assert "layers[0].map" in str(error.value)


def test_an_error_in_a_file_has_its_line(tmp_path):
    yaml = (
        "properties: {}\nlayers:\n- name: map\n  map:\n    segments:\n    - [0, 0, 1, 1]\n    - 3\n"
    )
    path = WorldFiles(tmp_path).write("world.yaml", yaml)
    with pytest.raises(FlatlandError, match=r"world.yaml:7(:\d+)?: layers\[0\].map.segments\[1\]"):
        Simulation(path)

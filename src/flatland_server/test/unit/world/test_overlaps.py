"""Models that are spawned within walls or other models: accepted, with a warning."""

import time

import pytest
from logged import warnings
from world.parts import spawn

from flatland_server.geometry import Pose

WORLD = """
properties: {{}}
layers: [{{name: walls, map: walls.yaml}}, {{name: floor}}]
models: {}
"""
BOX = """
bodies:
  - name: base
    type: {}
    footprints:
      - {{type: polygon, points: [[0, 0], [1, 0], [1, 1], [0, 1]], density: 1, {}}}
"""


@pytest.fixture
def world(files):
    """A wall along the y axis, and boxes of several kinds to be spawned."""
    files.walls("walls", (0, -5, 0, 5))
    for kind, key in (("sensor", "sensor: true"), ("ghost", "collision: false"), ("box", "")):
        files.write(f"{kind}.yaml", BOX.format("dynamic", key))
    files.write("other_layer.yaml", BOX.format("dynamic", "layers: [floor]"))
    files.write("static.yaml", BOX.format("static", ""))
    return files.load(WORLD.format("[]"))


def test_a_free_place_is_no_warning(files, world, caplog):
    model = spawn(files, world, "box.yaml", "box", pose=Pose(0.1, 0, 0))

    assert model.overlapping() == []
    assert world.overlap_warning(model) == ""
    assert warnings(caplog) == []


def test_a_model_spawned_in_an_overlap_causes_one_warning(files, world, caplog):
    first = spawn(files, world, "box.yaml", "first", pose=Pose(0.1, 0, 0))
    second = spawn(files, world, "box.yaml", "second", pose=Pose(-0.5, 0.5, 0))

    assert set(second.overlapping()) == {first, world.get_layer("walls")}
    [warning] = warnings(caplog)
    for words in ('the model "second" overlaps the ', 'the layer "walls"', 'the model "first"'):
        assert words in warning
    assert list(world.models) == ["first", "second"]


@pytest.mark.parametrize("kind", ["sensor", "ghost", "other_layer", "static"])
def test_overlaps_that_are_not_pushed_out_cause_no_warning(files, world, caplog, kind):
    spawn(files, world, f"{kind}.yaml", "box", pose=Pose(-0.5, 0, 0))

    assert warnings(caplog) == []


def test_a_models_own_bodies_do_not_count(models, caplog):
    world = models.load("{properties: {}, layers: []}")

    spawn(models, world, "plain.yaml", "two_bodies_in_one_place")

    assert warnings(caplog) == []


def test_the_check_is_cheap_among_many_walls(files):
    files.walls("walls", *[(x % 100, x // 100, x % 100 + 0.5, x // 100) for x in range(10_000)])
    files.write("box.yaml", BOX.format("dynamic", ""))
    world = files.load(WORLD.format("[]"))
    model = spawn(files, world, "box.yaml", "box", pose=Pose(50.2, 50.2, 0))

    begin = time.process_time()
    for _ in range(100):
        model.overlapping()

    assert time.process_time() - begin < 0.1, "1 ms each"

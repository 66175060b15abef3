"""Footprints: mass, collision layers, and shapes that Box2D cannot represent."""

import math

import pytest

from flatland_server.models.footprint import Footprint, Polygon
from flatland_server.models.model import ModelConfig

SQUARE = "[[0, 0], [1, 0], [1, 1], [0, 1]]"


def model(footprint: str) -> str:
    """A model file with this footprint on line 4, and a second body that is valid."""
    other = "{name: other, footprints: [{type: circle, radius: 1, density: 1}]}"
    return f"bodies:\n  - name: base\n    footprints:\n      - {footprint}\n  - {other}\n"


def world(*layers: str) -> str:
    """A world file of some layers without walls, and the model."""
    names = ", ".join(f"{{name: {layer}}}" for layer in layers)
    return f"properties: {{}}\nlayers: [{names}]\nmodels: [{{name: m, model: model.yaml}}]\n"


def read(files, footprint: str, *layers: str) -> Footprint:
    """The footprint, read from a world."""
    files.write("model.yaml", model(footprint))
    config: ModelConfig = files.load(world(*layers)).models["m"].config
    return config.bodies[0].footprints[0]


def refusal(files, footprint: str, *layers: str) -> str:
    """The error of loading a world with this footprint."""
    files.write("model.yaml", model(footprint))
    return files.refusal(world(*layers))


def test_a_polygon_may_be_clockwise_and_have_a_vertex_on_a_side(files):
    for points in (
        SQUARE,
        "[[0, 0], [0, 1], [1, 1], [1, 0]]",
        "[[0, 0], [0.5, 0], [1, 0], [1, 1], [0, 1]]",
    ):
        footprint = read(files, f"{{type: polygon, points: {points}, density: 1}}")

        assert isinstance(footprint.shape, Polygon)
        assert len(footprint.shape.vertices) == points.count("[") - 1


@pytest.mark.parametrize(
    ("footprint", "mass"),
    [
        ("{type: circle, radius: 0.5, center: [3, 1], density: 2}", 2 * math.pi * 0.25),
        (f"{{type: polygon, points: {SQUARE}, density: 3}}", 3.0),
        ("{type: circle, radius: 1, density: 2, sensor: true}", 2 * math.pi),
        ("{type: polygon, points: [[0, 0], [2, 1], [2, 0], [0, 1]], density: 3}", 6.0),  # the hull
    ],
)
def test_mass_is_area_times_density(files, footprint, mass):
    files.write("model.yaml", model(footprint))

    body = files.load(world()).models["m"].base.physics_body

    assert body.mass == pytest.approx(mass, rel=1e-5)


def test_a_footprint_has_the_bits_of_all_its_layers(files):
    footprint = read(files, "{type: circle, radius: 1, density: 1, layers: [c, a]}", "a", "b", "c")

    assert footprint.layer_bits == 0b101


@pytest.mark.parametrize(
    ("points", "density"),
    [
        ("[[0, 0], [1, 0], [2, 0]]", 1),  # on a line
        ("[[0, 0], [1, 1], [2, 2], [3, 3]]", 1),
        ("[[1, 1], [1, 1], [1, 1]]", 1),
        ("[[0, 0], [1e-4, 0], [0, 1e-4]]", 1),  # smaller than Box2D resolves
        ("[[0, 0], [1e6, 0], [0, 1]]", 1),  # beyond 100 km
        ("[[9e4, 0], [9.00001e4, 0], [9e4, 0.1]]", 1),  # small and far away
        (SQUARE, "1e39"),  # beyond single precision
    ],
)
def test_a_shape_impossible_in_box2d_is_refused_at_its_line(files, points, density):
    message = refusal(files, f"{{type: polygon, points: {points}, density: {density}}}")

    assert message.startswith("model.yaml:4: bodies[0].footprints[0]")


@pytest.mark.parametrize(
    ("points", "corners", "change"),
    [
        ("[[0, 0], [1, 1], [1, 0], [0, 1]]", 4, "in another order: 0 m2 before, 1"),
        ("[[0, 0], [4, 0], [2, 1], [4, 4]]", 3, "without [2, 1]: 4 m2 before, 8"),
        ("[[0, 3], [2, -3], [-3, 1], [3, 1], [-2, -3]]", 5, "in another order: 16 m2 before, 26"),
    ],
    ids=["crossed", "a dent", "a pentagram"],
)
def test_a_polygon_that_is_not_convex_is_its_hull(files, caplog, points, corners, change):
    footprint = read(files, f"{{type: polygon, points: {points}, density: 1}}")

    assert len(footprint.shape.vertices) == corners
    place = "model.yaml:4: bodies[0].footprints[0].points"
    expected = f"{place}: expected a convex polygon; its hull is taken, {change} m2 now"
    assert [record.getMessage()[-len(expected) :] for record in caplog.records] == [expected]

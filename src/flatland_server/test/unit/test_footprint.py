"""Footprints: the documented defaults, and shapes that Box2D cannot take."""

import math

import pytest

from flatland_server import _core
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.footprint import Circle, Footprint, Polygon
from flatland_server.models.model import ModelConfig

SQUARE = "[[0, 0], [1, 0], [1, 1], [0, 1]]"
PENTAGRAM = [
    [round(math.cos(4 * math.pi * i / 5), 3), round(math.sin(4 * math.pi * i / 5), 3)]
    for i in range(5)
]
NONAGON = [
    [round(math.cos(2 * math.pi * i / 9), 3), round(math.sin(2 * math.pi * i / 9), 3)]
    for i in range(9)
]


def model(footprint: str) -> str:
    """A model file with this footprint on line 4, and a body in which nothing is wrong."""
    other = "{name: other, footprints: [{type: circle, radius: 1, density: 1}]}"
    return f"bodies:\n  - name: base\n    footprints:\n      - {footprint}\n  - {other}\n"


def world(*layers: str) -> str:
    """A world file of some layers without walls, and the model."""
    names = ", ".join(f"{{name: {layer}}}" for layer in layers)
    return f"properties: {{}}\nlayers: [{names}]\nmodels: [{{name: m, model: model.yaml}}]\n"


def read(files, footprint: str, *layers: str) -> Footprint:
    """A footprint as the world has it."""
    files.write("model.yaml", model(footprint))
    config: ModelConfig = files.load(world(*layers)).models["m"].config
    return config.bodies[0].footprints[0]


def refusal(files, footprint: str, *layers: str) -> str:
    """Why a world with this footprint is not loaded."""
    files.write("model.yaml", model(footprint))
    return files.refusal(world(*layers))


def test_a_circle_has_the_documented_defaults(files):
    footprint = read(files, "{type: circle, radius: 0.5, density: 1}", "a")

    assert footprint == Footprint(
        shape=Circle((0.0, 0.0), 0.5),
        density=1.0,
        friction=0.0,
        restitution=0.0,
        sensor=False,
        collision=True,
        layers=("all",),
        layer_bits=0xFFFF,
    )


def test_a_polygon_may_go_either_way_round_and_have_a_corner_on_a_side(files):
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
    ],
)
def test_mass_is_area_times_density(files, footprint, mass):
    files.write("model.yaml", model(footprint))

    body = files.load(world()).models["m"].base.physics_body

    assert body.mass == pytest.approx(mass, rel=1e-5)


def test_the_layers_of_a_footprint_are_their_bits_together(files):
    footprint = read(files, "{type: circle, radius: 1, density: 1, layers: [c, a]}", "a", "b", "c")

    assert footprint.layer_bits == 0b101


def test_footprints_are_checked_without_a_physical_world(tmp_path, monkeypatch):
    monkeypatch.setattr(_core, "World", None)
    file = tmp_path / "model.yaml"
    file.write_text(model("{type: circle, radius: 1, density: 1}"))

    config = ModelConfig.from_file(file, CollisionFilterRegistry())

    assert [len(body.footprints) for body in config.bodies] == [1, 1]


@pytest.mark.parametrize(
    ("footprint", "message"),
    [
        pytest.param(
            "{type: circle, radius: 1}",
            '4: bodies[0].footprints[0]: the required key "density" is missing',
            id="density missing",
        ),
        pytest.param(
            "{type: circle, radius: 1, density: -1}",
            "4: bodies[0].footprints[0].density: expected a number of 0 or more, found -1",
            id="negative density",
        ),
        pytest.param(
            "{type: circle, radius: 0, density: 1}",
            "4: bodies[0].footprints[0].radius: expected a number above 0, found 0",
            id="radius of zero",
        ),
        pytest.param(
            "{type: circle, density: 1}",
            '4: bodies[0].footprints[0]: the required key "radius" is missing',
            id="radius missing",
        ),
        pytest.param(
            f"{{type: circle, radius: 1, points: {SQUARE}, density: 1}}",
            '4: bodies[0].footprints[0]: unknown key "points"',
            id="a polygon's key for a circle",
        ),
        pytest.param(
            "{type: square, radius: 1, density: 1}",
            '4: bodies[0].footprints[0].type: expected circle or polygon, found "square"',
            id="unknown type",
        ),
        pytest.param(
            "{type: polygon, points: [[0, 0], [2, 0], [1, 0.5], [2, 1], [0, 1]], density: 1}",
            "4: bodies[0].footprints[0].points: expected a convex polygon, found one with a dent",
            id="a dent",
        ),
        pytest.param(
            "{type: circle, radius: 1, density: 1, layers: [flor]}",
            '4: bodies[0].footprints[0].layers: no layer is named "flor" (did you mean "floor"?); '
            "there are: floor, walls",
            id="unknown layer",
        ),
        pytest.param(
            "{type: circle, radius: 1, density: 1, colision: false}",
            '4: bodies[0].footprints[0]: unknown key "colision" (did you mean "collision"?)',
            id="unknown key",
        ),
        pytest.param(
            "{type: circle, radius: 1, density: 1, friction: -0.1}",
            "4: bodies[0].footprints[0].friction: expected a number of 0 or more, found -0.1",
            id="negative friction",
        ),
    ],
)
def test_a_wrong_footprint_is_refused_at_its_line(files, footprint, message):
    assert refusal(files, footprint, "floor", "walls") == f"model.yaml:{message}"


def test_a_pentagram_turns_one_way_and_still_is_not_convex(files):
    message = refusal(files, f"{{type: polygon, points: {PENTAGRAM}, density: 1}}")

    assert message.startswith(
        "model.yaml:4: bodies[0].footprints[0].points: expected a convex polygon, found "
    )


def test_nine_corners_are_too_many(files):
    message = refusal(files, f"{{type: polygon, points: {NONAGON}, density: 1}}")

    assert message.startswith(
        "model.yaml:4: bodies[0].footprints[0].points: expected a list of 3 to 8 points [x, y], "
        "found [[1.0, 0.0], "
    )


@pytest.mark.parametrize(
    ("points", "density"),
    [
        pytest.param("[[0, 0], [1, 0], [2, 0]]", 1, id="on a level line"),
        pytest.param("[[0, 0], [1, 1], [2, 2], [3, 3]]", 1, id="on a slope"),
        pytest.param("[[1, 1], [1, 1], [1, 1]]", 1, id="one point"),
        pytest.param("[[0, 0], [1e-4, 0], [0, 1e-4]]", 1, id="smaller than Box2D resolves"),
        pytest.param("[[0, 0], [1e6, 0], [0, 1]]", 1, id="beyond 100 km"),
        pytest.param("[[9e4, 0], [9.00001e4, 0], [9e4, 0.1]]", 1, id="small and far away"),
        pytest.param(SQUARE, "1e39", id="a density beyond single precision"),
    ],
)
def test_a_shape_that_box2d_cannot_take_is_refused_at_its_line(files, points, density):
    message = refusal(files, f"{{type: polygon, points: {points}, density: {density}}}")

    assert message.startswith("model.yaml:4: bodies[0].footprints[0]")

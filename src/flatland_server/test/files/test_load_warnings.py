"""Worlds that load, but are probably not meant to be as they are: one warning, with its place."""

import warnings as python_warnings
from typing import Any, List

import numpy as np
import pytest
from logged import warnings
from PIL import Image

from flatland2d import Simulation, SimulationBatch
from flatland2d.cli import main

WORLD, MAP, LINES, MODEL = "world.yaml", "map.yaml", "lines.yaml", "robot.model.yaml"
ROOM = """\
properties: {}
layers:
  - {name: map, map: {segments: [[-5, -5, 5, -5], [5, -5, 5, 5], [5, 5, -5, 5], [-5, 5, -5, -5]]}}
models:
"""
DISC = "{name: base, footprints: [{type: circle, radius: 0.2, density: 1}]}"
DRIVE = "{type: DiffDrive, name: drive, body: base}"
LASER = "{type: Laser, name: laser, range: 5, angle: {min: 0, max: 0, increment: 1}"

# The file, what is replaced in it by what, and the beginning of the warning.
LASER_KEYS = "range: 10\n    angle: {min: -1, max: 1, increment: 0.1}\n    ignore_bodies: [wheel]"
ON_A_VERTEX = LASER_KEYS.replace("angle", "origin: [0.2, 0.1, 0]\n    angle").partition("ignore")[0]
TRAPS = {
    "a threshold in per cent": (MAP, "0.65", "65",
     "map.yaml:5: occupied_thresh: expected a fraction from 0 to 1 (below 1), found 65"),
    "a threshold below black": (MAP, "0.65", "-1",
     "map.yaml:5: occupied_thresh: expected a fraction from 0 to 1 (below 1), found -1"),
    "a threshold of white": (MAP, "0.65", "1.0",
     "map.yaml:5: occupied_thresh: expected a fraction from 0 to 1 (below 1), found 1"),
    "pixels of metres": (MAP, "0.05\norigin: [-1, -2, 0.5]", "5\norigin: [-9, -9, 0]",
     "map.yaml:2: resolution: expected metres per pixel, found 5"),
    "lines in millimetres": (LINES, "scale: 0.1", "scale: 2000",
     "lines.yaml:3: scale: expected a map of at most 5000 m, found 6323 m"),
    "a map turned by degrees": (MAP, "[-1, -2, 0.5]", "[-1, -2, 45]",
     "map.yaml:3: origin: expected an angle in rad, found 45: is it in degrees?"),
    "a model turned by degrees": (WORLD, "[1, 2, 0.5]", "[1, 2, -90]",
     "world.yaml:12: models[0].pose: expected an angle in rad, found -90: is it in degrees?"),
    "a body turned by degrees": (MODEL, "pose: [0, 0, 0]", "pose: [0, 0, 90]",
     "robot.model.yaml:4: bodies[0].pose: expected an angle in rad, found 90"),
    "a weld in degrees": (MODEL, "enabled: false\n    angle: 0", "enabled: true\n    angle: 90",
     "robot.model.yaml:35: joints[1].angle: expected an angle in rad, found 90"),
    "a hinge in degrees": (MODEL, "limits: [-1, 1]", "limits: [-45, 30]",
     "robot.model.yaml:27: joints[0].limits: expected an angle in rad, found -45"),
    "a lidar of no layers": (MODEL, "range: 10", "range: 10\n    layers: []",
     "robot.model.yaml:50: plugins[1].layers: expected the layers that it sees, found none: it "
     "sees nothing"),
    "a tag": (WORLD, "[1, 2, 0.5]", "[1, 2, !degrees 1]",
     "world.yaml:12: the tag \"!degrees\" is ignored"),
    "beams in degrees": (MODEL, "{min: -1, max: 1, increment: 0.1}",
     "{min: -90, max: 90, increment: 1}", "robot.model.yaml:50: plugins[1].angle.max: "
     "expected angles in rad, found a turn of 1.031e+04 degrees from min to max"),
    "beams in degrees, clockwise": (MODEL, "{min: -1, max: 1, increment: 0.1}",
     "{min: 90, max: -90, increment: -1}", "robot.model.yaml:50: plugins[1].angle.max: "
     "expected angles in rad, found a turn of -1.031e+04 degrees from min to max"),
    "a radius in millimetres": (MODEL, "radius: 0.5", "radius: 500", 'robot.model.yaml:2: '
     'bodies[0] "base": expected metres, found a footprint 500 m away, in a world of 10 m'),
    "a place in millimetres": (WORLD, "[1, 2, 0.5]", "[1000, 2000, 0.5]",
     "world.yaml:12: models[0].pose: expected metres, found a place 2235 m outside the walls"),
    "a drive of a static body": (MODEL, "type: dynamic", "type: static", "robot.model.yaml:44: "
     "plugins[0].body: expected a dynamic body, found a static one, which never moves"),
    "a drive of a kinematic body": (MODEL, "type: dynamic", "type: kinematic",
     "robot.model.yaml:44: plugins[0].body: expected a dynamic body, found a kinematic one, which "
     "is stopped by no wall"),
    "a body without density": (MODEL, "density: 1", "density: 0",
     "robot.model.yaml:2: bodies[0] \"base\": has 1 kg, and no push turns it: no footprint has a "
     "density"),
    "a lidar on a vertex": (MODEL, LASER_KEYS, ON_A_VERTEX,
     "robot.model.yaml:50: plugins[1].origin: is on the outline of a footprint of its own model"),
    "a lidar on a circle": (MODEL, "range: 10", "range: 10\n    origin: [0.3, -0.4, 0]",
     "robot.model.yaml:50: plugins[1].origin: is on the outline of a footprint of its own model"),
    "a lidar that sees its own robot": (MODEL, "ignore_bodies: [wheel]", "",
     "robot.model.yaml:46: plugins[1] \"laser\": is inside a footprint of its own model, and sees "
     "another one, of \"wheel\", that overlaps it: write \"ignore_bodies: [wheel]\""),
    "a lidar that stays behind": (MODEL, "body: base\n    range", "body: other\n    range",
     "robot.model.yaml:48: plugins[1].body: no joint holds \"other\" to \"base\", which is driven: "
     "it stays behind"),
}  # fmt: skip


def of_folder(files, found: List[str]) -> List[str]:
    return [files.without_folder(each) for each in found]


@pytest.mark.parametrize(("file", "old", "new", "warning"), TRAPS.values(), ids=TRAPS.keys())
def test_a_common_mistake_is_one_warning_with_its_place(
    good_files, caplog, file, old, new, warning
):
    other = "\n  - {name: other, footprints: [{type: circle, radius: 0.03, density: 1}]}\njoints:"
    good_files.edit(MODEL, "\njoints:", other)
    good_files.edit(file, old, new)

    world = good_files.load()
    world.reset()
    world.reset(7)
    good_files.load(seed=3)

    [found] = of_folder(good_files, warnings(caplog))
    line = int(warning.split(":")[1])
    shift = 1 if file == MODEL and line > 24 else 0  # by the other body
    assert found.startswith(warning.replace(f":{line}:", f":{line + shift}:", 1))


IMAGES = {
    "floats from 0 to 1": ("F", "tiff", 0.0, 1.0, "expected grey values up to 255, found floats"),
    "a transparent background": ("RGBA", "png", (0, 0, 0, 255), (0, 0, 0, 0),
     "has dark transparent pixels, which are walls: alpha is ignored"),
    "nothing bright": ("L", "png", 0, 160, "has no pixel brighter than occupied_thresh: it is one"),
}  # fmt: skip


@pytest.mark.parametrize(("mode", "kind", "dark", "free", "warning"), IMAGES.values(), ids=IMAGES)
def test_an_image_of_one_block_is_a_warning(good_files, caplog, mode, kind, dark, free, warning):
    image = Image.new(mode, (40, 40), free)
    image.paste(dark, (10, 10, 20, 20))
    image.save(good_files.folder / f"block.{kind}")
    good_files.edit(MAP, "map.png", f"block.{kind}")

    good_files.load()

    [found] = of_folder(good_files, warnings(caplog))
    assert found.startswith(f"map.yaml:1: image: {warning}")


def test_an_opaque_alpha_channel_causes_no_warning(good_files, caplog):
    """Pillow would print a warning of its own."""
    image = Image.new("P", (60, 40), 0)
    image.putpalette([254, 254, 254, 0, 0, 0, *[0] * 762])
    image.paste(1, (5, 5, 50, 30))
    image.save(good_files.folder / "map.png", transparency=bytes([255, 255, 128]))

    with python_warnings.catch_warnings():
        python_warnings.simplefilter("error")
        good_files.load()

    assert warnings(caplog) == []


# By OpenCV's imread (5.0), for JPEG, PNG and WebP: the corner of the upper left dark pixels.
TURNS = {1: (0, 0), 2: (0, 1), 3: (1, 1), 4: (1, 0), 5: (0, 0), 6: (0, 1), 7: (1, 1), 8: (1, 0)}


@pytest.mark.parametrize("kind", ["jpeg", "png", "webp"])
@pytest.mark.parametrize(("orientation", "corner"), TURNS.items())
def test_an_image_is_turned_as_its_exif_data_say(good_files, kind, orientation, corner):
    pixels = np.full((32, 64), 255, np.uint8)
    pixels[:8, :16] = 0  # at the upper left
    exif = Image.Exif()
    exif[0x0112] = orientation
    image = Image.fromarray(pixels).convert("RGB")
    image.save(good_files.folder / f"turned.{kind}", quality=100, exif=exif.tobytes())
    good_files.edit(MAP, "map.png", f"turned.{kind}")
    good_files.edit(MAP, "[-1, -2, 0.5]", "[0, 0, 0]")
    good_files.edit(MAP, "0.05", "1")

    walls = good_files.load().get_layer("map").segments.reshape(-1, 2)

    sides, size = ((64, 32), (16, 8)) if orientation < 5 else ((32, 64), (8, 16))
    down, right = corner
    low = np.array([right * (sides[0] - size[0]), (1 - down) * (sides[1] - size[1])])
    assert np.array_equal(walls.min(0), low)
    assert np.array_equal(walls.max(0), low + size)


def test_a_repeated_first_point_of_a_polygon_is_dropped(good_files, caplog):
    good_files.edit(MODEL, "[0.02, 0.1]]", "[0.02, 0.1], [0.02, 0]]")
    good_files.edit(MODEL, LASER_KEYS, ON_A_VERTEX)

    with python_warnings.catch_warnings():
        python_warnings.simplefilter("error")
        good_files.load()

    [found] = of_folder(good_files, warnings(caplog))
    assert "is on the outline" in found


# Places


def robots(*poses: str, plugins: str = "") -> str:
    model = f"{{bodies: [{DISC}], plugins: [{plugins}]}}"
    entries = [
        f"  - {{name: r{i}, pose: {pose}, model: {model}}}\n" for i, pose in enumerate(poses)
    ]
    return ROOM + "".join(entries)


@pytest.mark.parametrize(
    ("poses", "expected"),
    [
        (["[4.9, 0, 0]"], ['5: models[0].pose: begins within the layer "map", and is pushed out']),
        (
            ["[1, 1, 0]"] * 3,
            [
                '6: models[1].pose: begins within the model "r0", and is pushed out',
                '7: models[2].pose: begins within the model "r0", the model "r1", and is pushed '
                "out",
            ],
        ),
        (["[1, 1, 0]", "[1.5, 1, 0]"], []),
    ],
)
def test_a_model_within_another_or_a_wall_is_a_warning(files, caplog, poses, expected):
    files.write(WORLD, robots(*poses))

    world = files.load()
    world.reset()

    assert of_folder(files, warnings(caplog)) == [f"world.yaml:{each}" for each in expected]


@pytest.mark.parametrize(("place", "count"), [("[0.75, 1.2, 0]", 1), ("[1.6, 1.6, 0]", 0)])
def test_a_robot_in_a_dark_area_is_a_warning(good_files, caplog, place, count):
    """It touches no wall there: walls are the edges of dark areas."""
    good_files.edit(MAP, "[-1, -2, 0.5]", "[0, 0, 0]")
    good_files.edit(WORLD, "[1, 2, 0.5]", place)
    good_files.edit(MODEL, "radius: 0.5", "radius: 0.1")
    good_files.edit(MODEL, "layers: [map, walls]", "layers: [map]")
    good_files.edit(MODEL, "points: [[0.02", "layers: []\n        points: [[0.02")

    good_files.load()

    found = ['world.yaml:12: models[0].pose: begins within the layer "map"'][:count]
    assert of_folder(good_files, warnings(caplog)) == found


def test_a_model_alone_in_millimetres_is_a_warning(files, caplog, check):
    files.write(MODEL, f"bodies:\n  - {DISC}\n".replace("0.2", "200"))

    assert check(MODEL) == 0

    [found] = warnings(caplog)
    assert found.endswith("expected metres, found a footprint 200 m away")


def test_a_model_that_is_spawned_has_warnings_of_its_sensors(files, caplog):
    plugins = f"{DRIVE}, {LASER}, body: base, origin: [0.2, 0, 0]}}"
    files.write(MODEL, f"bodies: [{DISC}]\nplugins: [{plugins}]\n")
    files.write(WORLD, ROOM)

    world = files.load()
    for number in range(2):
        world.spawn_model(files.folder / MODEL, f"r{number}", f"r{number}", (number, 0.0, 0.0))

    [found] = [each for each in of_folder(files, warnings(caplog)) if "outline" in each]
    assert found.startswith("robot.model.yaml:2: plugins[1].origin: is on the outline of a foot")


def test_environments_and_simulations_do_not_repeat_a_warning(files, caplog):
    files.write(WORLD, robots("[4.9, 0, 0]", plugins=f"{DRIVE}, {LASER}, body: base}}"))

    for seed in range(3):
        Simulation(files.folder / WORLD, seed=seed).close()
    with SimulationBatch(files.folder / WORLD, 4) as batch:
        batch.reset()

    assert len(warnings(caplog)) == 1


# Frames of several robots


def test_robots_without_namespaces_are_told_to_have_some(files, caplog):
    files.write(WORLD, robots("[1, 1, 0]", "[3, 1, 0]", plugins=DRIVE))

    world = files.load()
    world.reset()

    found = of_folder(files, warnings(caplog))
    assert len(found) == 2
    for each in found:
        assert each.startswith('world.yaml:6: models[1].model.plugins[0] "drive": two ')
        assert "give each model" in each
        assert "switch" not in each


def test_two_plugins_of_a_model_are_told_that_one_is_enough(files, caplog):
    publishers = ", ".join(f"{{type: ModelTfPublisher, name: {n}}}" for n in ("a", "b"))
    files.write(WORLD, robots("[1, 1, 0]", plugins=publishers))

    files.load()

    for each in warnings(caplog):
        assert "switch one of them off" in each


# Files with errors


@pytest.fixture
def check(files, capsys, monkeypatch):
    """The errors of `flatland check`, for a file of the folder."""
    monkeypatch.chdir(files.folder)
    return lambda name: main(["check", name]) and capsys.readouterr().err.splitlines()


TRICYCLE = """\
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.3, density: 1}]}
  - {name: fw, footprints: [{type: circle, radius: 0.05, density: 1, sensor: true}]}
  - {name: lw, footprints: [{type: circle, radius: 0.05, density: 1, sensor: true}]}
  - {name: rw, footprints: [{type: circle, radius: 0.05, density: 1, sensor: true}]}
joints:
  - {type: revolute, name: fj, bodies: [{name: fw, anchor: [0, 0]}, {name: base, anchor: [0, 0]}]}
  - {type: weld, name: lj, bodies: [{name: lw, anchor: [0, 0]}, {name: base, anchor: [-1, 0.3]}]}
  - {type: weld, name: rj, bodies: [{name: rw, anchor: [0, 0]}, {name: base, anchor: [-1, -0.3]}]}
plugins:
  - {type: TricycleDrive, name: d, body: base, front_wheel_joint: fj, rear_left_wheel_joint: lj,
     rear_right_wheel_joint: rj}
"""
ERRORS: Any = {
    "a key of a plugin": ("body: base", "some_key: 1, body: base",
     'm.yaml:11:36: plugins[0] "d": unknown key "some_key"'),
    "a joint": ("name: fj", "name: fj, some_key: 1",
     'm.yaml:7:32: joints[0] "fj": unknown key "some_key"'),
    "the key of the bodies": ("bodies:\n", "body:\n",
     "m.yaml:1:1: expected a world, which has the keys"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "expected"), ERRORS.values(), ids=ERRORS.keys())
def test_an_error_causes_no_others(files, check, old, new, expected):
    files.write("m.yaml", TRICYCLE.replace(old, new, 1))

    [found] = check("m.yaml")

    assert found.startswith(expected)


def test_a_model_of_a_world_without_bodies_has_that_error_alone(good_files, check):
    good_files.edit(MODEL, "bodies:", "body:")

    found = check(WORLD)

    assert [each for each in found if "deleted" in each] == []
    assert any('unknown key "body" (did you mean "bodies"?)' in each for each in found)


def test_a_warning_is_given_once_beside_an_error(good_files, caplog, check):
    good_files.edit(MODEL, "[0.02, 0], [0.2, 0], [0.2, 0.1]", "[0.02, 0], [0.2, 0.1], [0.2, 0]")
    good_files.edit(MODEL, "name: drive", "name: drive\n    name: drive")
    good_files.edit(MODEL, "range: 10", "raneg: 10")

    check(WORLD)

    assert len(warnings(caplog)) == len(set(warnings(caplog))) == 2

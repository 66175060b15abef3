"""Wrong files: the error says exactly what is wrong and where.

The cases are in `wrong_files/`, by what is wrong.
"""

import time

import pytest
from wrong_files.case import DATA, LINES, MAP, MODEL, WORLD
from wrong_files.maps import WRONG_MAPS
from wrong_files.models import WRONG_MODELS
from wrong_files.syntax import WRONG_SYNTAX
from wrong_files.worlds import WRONG_WORLDS

from flatland_server.exceptions import FlatlandError, YamlError

WRONG = {**WRONG_WORLDS, **WRONG_MAPS, **WRONG_MODELS, **WRONG_SYNTAX}

# Numbers that are too large or too small for physics: the file, the string in it that is replaced,
# its replacement, and how the error begins. The rest of the message is that of the core.
TOO_MUCH = {
    "iterations": (WORLD, "velocity_iterations: 10", "velocity_iterations: 99999999999", WORLD),
    "a model's position": (WORLD, "[1, 2, 0.5]", "[1e39, 2, 0.5]", ""),
    "an image's resolution": (MAP, "resolution: 0.05", "resolution: 1e300", MAP),
    "an image's tiny resolution": (MAP, "resolution: 0.05", "resolution: 1e-300", MAP),
    "an image's origin": (MAP, "[-1, -2, 0.5]", "[1e300, 0, 0]", MAP),
    "a scale": (LINES, "scale: 0.1", "scale: 1e300", LINES),
    "a tiny scale": (LINES, "scale: 0.1", "scale: 1e-300", LINES),
    "a line segment": (DATA, "2 3 -1 2", "1e300 1e300 0 0", "lines."),
    "a radius": (MODEL, "radius: 0.5", "radius: 1e300", MODEL),
    "a tiny radius": (MODEL, "radius: 0.5", "radius: 1e-300", MODEL),
    "a center": (MODEL, "center: [0, 0]", "center: [1e300, 0]", MODEL),
    "a point": (MODEL, "[0.2, 0.1]", "[1e300, 0.1]", MODEL),
    "a density": (MODEL, "density: 1", "density: 1e300", MODEL),
    "friction": (MODEL, "friction: 0.1", "friction: 1e300", MODEL),
    "restitution": (MODEL, "restitution: 0", "restitution: 1e300", MODEL),
    "a body's pose": (MODEL, "pose: [0, 0, 0]", "pose: [1e300, 0, 0]", ""),
    "damping": (MODEL, "linear_damping: 0", "linear_damping: 1e300", ""),
    "an anchor": (MODEL, "anchor: [0.5, 0]", "anchor: [1e300, 0]", ""),
    "limits of a hinge": (MODEL, "limits: [-1, 1]", "limits: [-1e300, 1e300]", ""),
    "a drive's limit": (MODEL, "{velocity_limit: 1}", "{velocity_limit: 1e300}", MODEL),
    "a laser's range": (MODEL, "range: 10", "range: 1e300", MODEL),
    "a laser's origin": (MODEL, "range: 10", "range: 10\n    origin: [1e300, 0, 0]", MODEL),
}


@pytest.fixture
def spoilt(good_files):
    """A folder with a world that loads, and with invalid files that it can be made to name."""
    (good_files.folder / "folder").mkdir()
    image = (good_files.folder / "map.png").read_bytes()
    middle = len(image) // 2
    good_files.write("cut.png", image[:middle])
    good_files.write("corrupt.png", image[:middle] + bytes(8) + image[middle + 8 :])
    good_files.write("empty.png", b"")
    good_files.write("ping.yaml", "x: $include pong.yaml\n")
    good_files.write("pong.yaml", "y: $include ping.yaml\n")
    good_files.write("two.yaml", "name: first\n---\nnaem: second\n")
    good_files.write("empty.yaml", "")
    good_files.write("short_pose.yaml", b"\n[1, 2]\n")
    return good_files


def test_the_files_are_valid_before_they_are_changed(spoilt):
    world = spoilt.load()

    assert [layer.name for layer in world.layers] == ["map", "lines", "floor"]
    assert world.plugin_count == 2
    world.close()


@pytest.mark.parametrize(("file", "old", "new", "message"), WRONG.values(), ids=WRONG.keys())
def test_the_error_of_a_wrong_file_says_what_is_wrong_and_where(spoilt, file, old, new, message):
    if old is None:
        (spoilt.folder / file).write_bytes(new if isinstance(new, bytes) else new.encode())
    else:
        spoilt.edit(file, old, new)

    assert spoilt.refusal() == message


@pytest.mark.parametrize(("file", "old", "new", "fault"), TOO_MUCH.values(), ids=TOO_MUCH.keys())
def test_a_number_that_physics_cannot_represent_is_refused(spoilt, file, old, new, fault):
    spoilt.edit(file, old, new)

    assert spoilt.refusal().startswith(fault)


@pytest.mark.parametrize(
    ("old", "new"),
    [("map: map.yaml", "map: {}"), ("model: robot", "model: {}"), ("[1, 2, 0.5]", "$include {}")],
)
def test_a_file_name_that_is_too_long_is_refused(good_files, old, new):
    name = "a" * 300
    good_files.edit("world.yaml", old, new.format(name))

    message = good_files.refusal()

    assert message.startswith("world.yaml:")
    assert name in message


def test_a_missing_world_or_a_folder_is_named(files):
    assert files.refusal() == "world.yaml: cannot be read: No such file or directory"
    (files.folder / "world.yaml").mkdir()
    assert files.refusal() == "world.yaml: cannot be read: Is a directory"


def test_a_list_for_a_merge_key_is_refused(good_files):
    good_files.edit("world.yaml", "- name: floor", "- {name: floor, <<: {[color]: 2}}")

    assert good_files.refusal().startswith("world.yaml:8: ")


def bomb(kind: str) -> str:
    """A document in which each alias stands for nine of the previous one."""
    levels = ["x0: &x0 {k: 1}" if kind != "lists" else "x0: &x0 [1]"]
    for i in range(1, 9):
        nine = [f"*x{i - 1}"] * 9
        if kind == "lists":
            value = f"[{', '.join(nine)}]"
        elif kind == "maps":
            value = f"{{{', '.join(f'{key}: {item}' for key, item in zip('abcdefghi', nine))}}}"
        else:
            value = f"{{k{i}: 1, <<: [{', '.join(nine)}]}}"
        levels.append(f"x{i}: &x{i} {value}")
    return "\n".join(levels)


@pytest.mark.parametrize(
    ("kind", "key"),
    [
        *(("lists", key) for key in ("x", "properties", "layers", "models")),
        *(("maps", key) for key in ("x", "properties", "layers")),
        ("merged maps", "x"),
    ],
)
def test_an_alias_bomb_is_refused_quickly(files, kind, key):
    files.write("world.yaml", f"{bomb(kind)}\n{key}: *x8\n")

    begin = time.process_time()
    message = files.refusal()

    assert time.process_time() - begin < 1.0
    if kind == "merged maps":  # these are merged into few keys
        assert 'world.yaml:1: unknown key "x0"' in message.splitlines()
    else:
        assert message.startswith("world.yaml:6: expected at most 1000000 keys and values")
    assert len(message) < 5_000


def test_an_include_bomb_is_refused_quickly(files):
    files.write("world.yaml", "properties: {}\nlayers: []\nx: $include 0.yaml\n")
    for i in range(5):
        files.write(f"{i}.yaml", f"[{', '.join([f'$include {i + 1}.yaml'] * 9)}]\n")
    files.write("5.yaml", "1\n")

    begin = time.process_time()
    files.refusal()

    assert time.process_time() - begin < 2.0


def test_problems_of_several_files_are_reported_together(good_files):
    good_files.edit("world.yaml", "velocity_iterations: 10", "velocity_iterations: 0")
    good_files.edit("world.yaml", "[0.4, 0.4, 0.4, 1]", "grey")
    good_files.edit("world.yaml", "pose: [1, 2, 0.5]", "pose: [1, 2]")
    good_files.edit("map.yaml", "resolution: 0.05", "resolution: 0")
    good_files.edit("map.yaml", "map.png", "office.png")
    good_files.edit("robot.model.yaml", "radius: 0.5", "radius: -0.5")
    good_files.edit("robot.model.yaml", "collide_connected: false", "collide_connectd: false")
    good_files.edit("robot.model.yaml", "name: laser", "name: drive")
    good_files.edit("lines.dat", "2 3 -1 2", "2 3 -1")

    assert good_files.refusal().splitlines() == [
        "world.yaml:1: properties.velocity_iterations: expected a whole number of 1 or more, "
        "found 0",
        'world.yaml:5: layers[0].color: expected [r, g, b, alpha], each 0 to 1, found "grey"',
        "map.yaml:2: resolution: expected a number above 0, found 0",
        "map.yaml:1: image: expected a file, but office.png is not there",
        'lines.dat:2: expected four numbers, x1 y1 x2 y2, found "2 3 -1"',
        "world.yaml:12: models[0].pose: expected [x, y, yaw], found [1, 2]",
        "robot.model.yaml:11: bodies[0].footprints[0].radius: "
        "expected a number above 0, found -0.5",
        'robot.model.yaml:28: joints[0] "hinge": unknown key "collide_connectd" '
        '(did you mean "collide_connected"?)',
        'robot.model.yaml:47: plugins[1].name: the name "drive" is given twice',
    ]


def test_problems_of_all_plugins_are_reported_together(good_files):
    good_files.edit("robot.model.yaml", "velocity_limit", "velocity_limt")
    good_files.edit("robot.model.yaml", "range: 10", "range: 0")
    good_files.edit("robot.model.yaml", "min: -1", "min: left")

    assert good_files.refusal().splitlines() == [
        'robot.model.yaml:45: plugins[0].linear_dynamics: unknown key "velocity_limt" '
        '(did you mean "velocity_limit"?)',
        'robot.model.yaml:50: plugins[1].angle.min: expected a number, found "left"',
        "robot.model.yaml:49: plugins[1].range: expected a number above 0, found 0",
    ]


def test_an_error_has_file_line_and_column_of_the_value(good_files):
    good_files.edit("robot.model.yaml", "radius: 0.5", "radius: none")

    with pytest.raises(YamlError) as caught:
        good_files.load()

    assert isinstance(caught.value, FlatlandError)
    assert caught.value.file == good_files.folder / "robot.model.yaml"
    assert (caught.value.line, caught.value.column) == (11, 17)


LONG = "a b" * 30_000

LONG_TEXTS = {
    "an unknown key": (WORLD, "properties: {", f"'{LONG}': 1\nproperties: {{"),
    "a key twice": (WORLD, "properties: {", f"'{LONG}': 1\n'{LONG}': 1\nproperties: {{"),
    "a name of a layer": (WORLD, "name: floor", f"name: '{LONG}'"),
    "a colour": (WORLD, "[0.4, 0.4, 0.4, 1]", f"'{LONG}'"),
    "an alias": (WORLD, "[0.4, 0.4, 0.4, 1]", f"*{'a' * 90_000}"),
    "an expression": (WORLD, "[0.4, 0.4, 0.4, 1]", f"$eval error('{LONG}')"),
    "a layer": (MODEL, "layers: [map, walls]", f"layers: ['{LONG}']"),
    "a body of a joint": (MODEL, "{name: base, anchor", f"{{name: '{LONG}', anchor"),
    "a body of a plugin": (MODEL, "body: base", f"body: '{LONG}'"),
    "a type of plugin": (MODEL, "type: Laser", f"type: '{LONG}'"),
    "a line of data": (DATA, "2 3 -1 2", LONG),
}


@pytest.mark.parametrize(("file", "old", "new"), LONG_TEXTS.values(), ids=LONG_TEXTS.keys())
def test_a_long_value_is_quoted_in_part(good_files, file, old, new):
    good_files.edit(file, old, new)

    assert max(map(len, good_files.refusal().splitlines())) < 400


def test_a_file_of_another_kind_is_not_quoted_at_length(files):
    secret = "".join(f"user{i}:x:{i}:{i}:Name {i}:/home/user{i}:/bin/bash\n" for i in range(50))
    files.write("world.yaml", secret)

    message = files.refusal()

    assert message.startswith("world.yaml:1: expected a map, found ")
    assert "user2" not in message

"""YamlReader: the getter decides about the type; an error for a wrong value has file and line."""

import math
from typing import Any, Dict

import pytest
from yaml_reader.reading import SHAPES, nothing, read, refusal

from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import YamlError
from flatland_server.geometry import Pose

TYPES = ["static", "kinematic", "dynamic"]


WRONG_VALUES: Dict[str, Any] = {
    # mistake: text of the file, getter, message after "<file>:"
    "a word for a number": (
        "mass: heavy",
        lambda r: r.get_float("mass"),
        '1: mass: expected a number, found "heavy"',
    ),
    "a list for a number": (
        "mass: [1, a]",
        lambda r: r.get_float("mass"),
        '1: mass: expected a number, found [1, "a"]',
    ),
    "a map for a number": (
        "mass: {kg: 1}",
        lambda r: r.get_float("mass"),
        "1: mass: expected a number, found a map",
    ),
    "true for a number": (
        "mass: true",
        lambda r: r.get_float("mass"),
        "1: mass: expected a number, found true",
    ),
    "NaN in YAML's spelling": (
        "mass: .nan",
        lambda r: r.get_float("mass"),
        "1: mass: expected a number, found .nan",
    ),
    "NaN in Python's spelling": (
        "mass: nan",
        lambda r: r.get_float("mass", allow_infinity=True),
        '1: mass: expected a number, found "nan"',
    ),
    "infinity": (
        "mass: .inf",
        lambda r: r.get_float("mass"),
        "1: mass: expected a finite number, found .inf",
    ),
    "minus infinity": (
        "mass: -.inf",
        lambda r: r.get_float("mass"),
        "1: mass: expected a finite number, found -.inf",
    ),
    "a number too large for a computer": (
        "mass: 1.0e+999",
        lambda r: r.get_float("mass"),
        "1: mass: expected a finite number, found 1.0e+999",
    ),
    "a negative number": (
        "mass: -1",
        lambda r: r.get_float("mass", minimum=0.0),
        "1: mass: expected a number of 0 or more, found -1",
    ),
    "zero": (
        "radius: 0",
        lambda r: r.get_float("radius", above=0.0),
        "1: radius: expected a number above 0, found 0",
    ),
    "a rate of zero": (
        "rate: 0.0",
        lambda r: r.get_rate("rate"),
        "1: rate: expected a number above 0, found 0.0",
    ),
    "a rate of minus infinity": (
        "rate: -.inf",
        lambda r: r.get_rate("rate"),
        "1: rate: expected a number above 0, found -.inf",
    ),
    "a fraction for a whole number": (
        "count: 1.5",
        lambda r: r.get_int("count"),
        "1: count: expected a whole number, found 1.5",
    ),
    "too small a whole number": (
        "count: 0",
        lambda r: r.get_int("count", minimum=1),
        "1: count: expected a whole number of 1 or more, found 0",
    ),
    "a number for yes or no": (
        "sensor: 1",
        lambda r: r.get_bool("sensor"),
        "1: sensor: expected true or false, found 1",
    ),
    "a list for a string": (
        "name: [a, b]",
        lambda r: r.get_string("name"),
        '1: name: expected a string, found ["a", "b"]',
    ),
    "none of the choices": (
        "type: wobbly",
        lambda r: r.get_choice("type", TYPES),
        '1: type: expected static, kinematic or dynamic, found "wobbly"',
    ),
    "nearly one of the choices": (
        "type: circel",
        lambda r: r.get_choice("type", SHAPES),
        '1: type: expected circle or polygon (did you mean "circle"?), found "circel"',
    ),
    "too short a list": (
        "noise: [0, 1]",
        lambda r: r.get_floats("noise", 3),
        "1: noise: expected a list of 3 numbers, found [0, 1]",
    ),
    "a list with a word": (
        "noise: [0, much, 1]",
        lambda r: r.get_floats("noise", 3),
        '1: noise: expected a list of 3 numbers, found [0, "much", 1]',
    ),
    "a list with a negative number": (
        "noise: [0, -1, 0]",
        lambda r: r.get_floats("noise", 3, minimum=0.0),
        "1: noise: expected a list of 3 numbers of 0 or more, found [0, -1, 0]",
    ),
    "a word for a pose": (
        "pose: foo",
        lambda r: r.get_pose("pose"),
        '1: pose: expected [x, y, yaw], found "foo"',
    ),
    "an infinite pose": (
        "pose: [0, .inf, 0]",
        lambda r: r.get_pose("pose"),
        "1: pose: expected [x, y, yaw], found [0, .inf, 0]",
    ),
    "three coordinates for a point": (
        "center: [0, 0, 0]",
        lambda r: r.get_point("center"),
        "1: center: expected [x, y], found [0, 0, 0]",
    ),
    "two corners": (
        "points: [[0, 0], [1, 0]]",
        lambda r: r.get_points("points", 3, 8),
        "1: points: expected a list of 3 to 8 points [x, y], found [[0, 0], [1, 0]]",
    ),
    "a number for corners": (
        "points: 3",
        lambda r: r.get_points("points", 3, 8),
        "1: points: expected a list of 3 to 8 points [x, y], found 3",
    ),
    "too bright a colour": (
        "color: [0, 0, 0, 255]",
        lambda r: r.get_color("color"),
        "1: color: expected [r, g, b, alpha], found [0, 0, 0, 255]",
    ),
    "a map for strings": (
        "layers: {a: b}",
        lambda r: r.get_strings("layers"),
        "1: layers: expected a string, found a map",
    ),
    "a list for a section": (
        "angle:\n  [1, 2]",
        lambda r: r.get_section("angle").get_float("min"),
        "2: angle: expected a map, found [1, 2]",
    ),
    "a map for a list": (
        "models: {name: a}",
        lambda r: r.get_sections("models", nothing),
        "1: models: expected a list, found a map",
    ),
    "a word for an entry": (
        "models:\n  - name: a\n  - robot",
        lambda r: r.get_sections("models", nothing),
        '3: models[1]: expected a map, found "robot"',
    ),
    "nothing for an entry": (
        "models: [~]",
        lambda r: r.get_sections("models", nothing),
        "1: models[0]: expected a map, found nothing",
    ),
    "a long value": (
        f"mass: {'x' * 100}",
        lambda r: r.get_float("mass"),
        f'1: mass: expected a number, found "{"x" * 56}...',
    ),
    "a missing key": (
        "mass: 1",
        lambda r: r.get_string("name"),
        '1: the required key "name" is missing',
    ),
    "a required key with nothing": (
        "mass:",
        lambda r: r.get_float("mass"),
        '1: the required key "mass" is missing',
    ),
    "a missing key of an entry": (
        "models:\n  - name: a\n  - {name: b, model: b}",
        lambda r: r.get_sections("models", lambda m: (m.get_string("model"), m.raise_problems())),
        '2: models[0] "a": the required key "model" is missing',
    ),
    "a missing section": (
        "a: 1",
        lambda r: r.get_section("angle", required=True).get_float("min"),
        '1: the required key "angle" is missing',
    ),
    "a missing list": (
        "a: 1",
        lambda r: r.get_sections("layers", nothing, required=True),
        '1: the required key "layers" is missing',
    ),
    "an unknown key": (
        "name: a\nweight: 1",
        lambda r: (r.get_string("name"), r.finish()),
        '2: unknown key "weight"',
    ),
    "a key nearly known": (
        "plugins:\n  - type: Laser\n    name: laser\n    raneg: 5",
        lambda r: r.get_sections(
            "plugins",
            lambda p: (
                p.get_string("type"),
                p.get_string("name"),
                p.get_rate("range", 1),
                p.finish(),
            ),
        ),
        '4: plugins[0] "laser": unknown key "raneg" (did you mean "range"?)',
    ),
    "an unknown key of a section": (
        "debug: {min_z: 1, max: 2}",
        lambda r: [
            (s.get_float("min_z"), s.get_float("max_z", 0.0), s.finish())
            for s in [r.get_section("debug")]
        ],
        '1: debug: unknown key "max" (did you mean "max_z"?)',
    ),
    "a pose deep within": (
        "layers: []\nmodels:\n  - name: a\n    model: a.yaml\n    pose: foo",
        lambda r: r.get_sections("models", lambda m: (m.get_pose("pose"), m.raise_problems())),
        '5: models[0].pose: expected [x, y, yaw], found "foo"',
    ),
}


READINGS: Dict[str, Any] = {
    "1e3": (lambda r: r.get_float("v"), 1000.0),
    "-.5": (lambda r: r.get_float("v"), -0.5),
    '"2.5"': (lambda r: r.get_float("v"), 2.5),
    "inf": (lambda r: r.get_rate("v"), math.inf),
    ".inf": (lambda r: r.get_rate("v"), math.inf),
    ".Inf": (lambda r: r.get_rate("v"), math.inf),
    "+.inf": (lambda r: r.get_rate("v"), math.inf),
    "yes": (lambda r: r.get_bool("v"), True),
    "On": (lambda r: r.get_bool("v"), True),
    "TRUE": (lambda r: r.get_bool("v"), True),
    "no": (lambda r: r.get_bool("v"), False),
    "off": (lambda r: r.get_bool("v"), False),
    "-7": (lambda r: r.get_int("v"), -7),
    "0x": (lambda r: r.get_string("v"), "0x"),
    "007": (lambda r: r.get_string("v"), "007"),
    "no # a string": (lambda r: r.get_string("v"), "no"),
    "''": (lambda r: r.get_string("v"), ""),
    "map": (lambda r: r.get_strings("v"), ("map",)),
    "[a, 2]": (lambda r: r.get_strings("v"), ("a", "2")),
    "[]": (lambda r: r.get_strings("v"), ()),
    "[1e1, 2, 0.5]": (lambda r: tuple(r.get_pose("v")), (10.0, 2.0, 0.5)),
    "[0, 0.5, 1, 1]": (lambda r: r.get_color("v"), (0.0, 0.5, 1.0, 1.0)),
    "~": (lambda r: r.get_float("v", 4.0), 4.0),
    "null": (lambda r: [r.get_sections("v", nothing), r.has("v")], [[], False]),
    "{a: 1}": (lambda r: r.get_section("v").get_int("a"), 1),
}


@pytest.mark.parametrize("case", WRONG_VALUES)
def test_a_wrong_value_is_named_with_its_place(tmp_path, case):
    text, getter, message = WRONG_VALUES[case]

    assert refusal(tmp_path, text, getter) == f"file.yaml:{message}"


@pytest.mark.parametrize(
    ("getter", "kind"),
    [
        (lambda r: r.get_string("v"), str),
        (lambda r: r.get_float("v"), float),
        (lambda r: r.get_rate("v"), float),
        (lambda r: r.get_int("v"), int),
        (lambda r: r.get_bool("v"), bool),
        (lambda r: r.get_pose("v"), Pose),
        (lambda r: r.get_point("v"), tuple),
        (lambda r: r.get_points("v", 3, 8), list),
        (lambda r: r.get_color("v"), tuple),
        (lambda r: r.get_section("v"), YamlReader),
        (lambda r: r.get_sections("v", nothing), list),
    ],
)
def test_a_wrong_value_is_replaced_by_a_placeholder_of_its_type(tmp_path, getter, kind):
    for text in ("v: {a: [b]}" if kind is not YamlReader else "v: [1]", "w: 1"):
        reader = read(tmp_path, text)

        value = getter(reader)

        assert isinstance(value, kind)
        if kind not in (YamlReader, list):  # a section or a list need not be there
            assert not reader.is_sound
            with pytest.raises(YamlError):
                reader.finish()


@pytest.mark.parametrize("text", READINGS)
def test_the_getter_decides_about_the_type_of_a_value(tmp_path, text):
    getter, expected = READINGS[text]

    assert getter(read(tmp_path, f"v: {text}\n")) == expected

"""YamlReader: the getter decides about the type; an error for a wrong value has file and line.

Most wrong values and documents are in `files/wrong_files/`: they are read as worlds.
"""

import math
from typing import Any, Dict

import pytest
from yaml_reader.reading import nothing, read, refusal

from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import YamlError
from flatland_server.geometry import Pose

TYPES = ["static", "kinematic", "dynamic"]


WRONG_VALUES = [
    # text of the key "v", getter, message
    ("true", lambda r: r.get_float("v"), "expected a number, found true"),
    ("nan", lambda r: r.get_float("v", allow_infinity=True), 'expected a number, found "nan"'),
    ("-.inf", lambda r: r.get_float("v"), "expected a finite number, found -.inf"),
    ("1.0e+999", lambda r: r.get_float("v"), "expected a finite number, found 1.0e+999"),
    ("x" * 100, lambda r: r.get_float("v"), f'expected a number, found "{"x" * 56}...'),
    ("0.0", lambda r: r.get_rate("v"), "expected a number above 0, found 0.0"),
    (
        '[0, "much", 1]',
        lambda r: r.get_floats("v", 3),
        'expected a list of 3 numbers, found [0, "much", 1]',
    ),
    (
        "[0, -1, 0]",
        lambda r: r.get_floats("v", 3, minimum=0.0),
        "expected a list of 3 numbers of 0 or more, found [0, -1, 0]",
    ),
    ("3", lambda r: r.get_points("v", 3, 8), "expected a list of 3 to 8 points [x, y], found 3"),
]


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


@pytest.mark.parametrize(("text", "getter", "message"), WRONG_VALUES)
def test_a_wrong_value_is_named_with_its_place(tmp_path, text, getter, message):
    assert refusal(tmp_path, f"v: {text}", getter) == f"file.yaml:1: v: {message}"


def test_a_key_or_an_entry_without_a_value_is_named(tmp_path):
    message = refusal(tmp_path, "mass:", lambda r: r.get_float("mass"))
    assert message == 'file.yaml:1: the required key "mass" has no value'
    message = refusal(tmp_path, "models: [~]", lambda r: r.get_sections("models", nothing))
    assert message == "file.yaml:1: models[0]: expected a map, found nothing"


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


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(tmp_path):
    (tmp_path / "file.yaml").write_bytes(b"\xef\xbb\xbfa: 1\r\nb: two\r\n")

    reader = YamlReader.from_file(tmp_path / "file.yaml")

    assert (reader.get_int("a"), reader.get_string("b")) == (1, "two")


def test_an_alias_stands_for_its_anchor(tmp_path):
    reader = read(tmp_path, "a: &start [1, 2, 3]\nb: *start")

    assert tuple(reader.get_pose("b")) == (1.0, 2.0, 3.0)

"""YamlReader: values are read as what is asked for; whatever is wrong has a file and a line."""

import contextlib
import math
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any, Callable, Dict

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from flatland_server.exceptions import YamlError
from flatland_server.geometry import Pose
from flatland_server.yaml_reader import YamlReader

Read = Callable[[YamlReader], Any]
SHAPES = ["circle", "polygon"]
TYPES = ["static", "kinematic", "dynamic"]


def nothing(section: YamlReader) -> None:
    """Reads nothing of a section."""


WRONG_VALUES: Dict[str, Any] = {
    # what is wrong: text, who reads it, message after "<file>:"
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
    "a list for a text": (
        "name: [a, b]",
        lambda r: r.get_string("name"),
        '1: name: expected a text, found ["a", "b"]',
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
    "a map for texts": (
        "layers: {a: b}",
        lambda r: r.get_strings("layers"),
        "1: layers: expected a text, found a map",
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

WRONG_STRUCTURES = {
    "a key given twice": ("mass: 1\nmass: 2", '2: the key "mass" is given twice'),
    "a list as a key": ("[a]: 1", '1: expected a key, found ["a"]'),
    "a list for the whole": ("# robots\n- a\n- b", '2: expected a map, found ["a", "b"]'),
    "a text for the whole": ("hello", '1: expected a map, found "hello"'),
}

NOT_YAML = {
    "a tab": (b"models:\n\t- name: a", 2),
    "an open bracket": (b"a: 1\npose: [0, 0\nname: x", 3),
    "an unknown alias": (b"a: *robot", 1),
    "bad indentation": (b"a:\n    b: 1\n  c: 2", 3),
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
    "no # a text": (lambda r: r.get_string("v"), "no"),
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


def read(folder: Path, text: str) -> YamlReader:
    """A reader of a file with this text."""
    path = folder / "file.yaml"
    path.write_text(text, encoding="utf-8")
    return YamlReader.from_file(path)


def refusal(folder: Path, text: str, getter: Read) -> str:
    """What is wrong with a file's text, without the folder's name."""

    def read_all() -> None:
        reader = read(folder, text)
        getter(reader)
        reader.raise_problems()

    with pytest.raises(YamlError) as caught:
        read_all()
    message = str(caught.value).replace(f"{folder}/", "")
    assert caught.value.line == int(message.split(":")[1])
    return message


@pytest.mark.parametrize("case", WRONG_VALUES)
def test_a_wrong_value_is_named_with_its_place(tmp_path, case):
    text, getter, message = WRONG_VALUES[case]

    assert refusal(tmp_path, text, getter) == f"file.yaml:{message}"


@pytest.mark.parametrize("case", WRONG_STRUCTURES)
def test_a_wrong_structure_is_named_with_its_line(tmp_path, case):
    text, message = WRONG_STRUCTURES[case]

    assert refusal(tmp_path, text, nothing) == f"file.yaml:{message}"


def test_all_that_is_wrong_is_said_at_once_in_the_order_of_reading(tmp_path):
    text = """\
properties: {gravity: heavy}
name: [a]
models:
  - {name: a, pose: foo, model: a.yaml}
  - {name: b, model: b.yaml}
  - {name: c}
  - d
weight: 1
"""

    def read_model(section: YamlReader) -> None:
        section.get_string("name")
        section.get_string("model")
        section.get_pose("pose", Pose())
        section.finish()

    def read_all(reader: YamlReader) -> None:
        properties = reader.get_section("properties")
        properties.get_float("gravity")
        properties.get_float("mass")
        properties.finish()
        reader.get_string("name")
        reader.get_sections("models", read_model)
        reader.finish()

    assert refusal(tmp_path, text, read_all).splitlines() == [
        'file.yaml:1: properties.gravity: expected a number, found "heavy"',
        'file.yaml:1: properties: the required key "mass" is missing',
        'file.yaml:2: name: expected a text, found ["a"]',
        'file.yaml:4: models[0].pose: expected [x, y, yaw], found "foo"',
        'file.yaml:6: models[2] "c": the required key "model" is missing',
        'file.yaml:7: models[3]: expected a map, found "d"',
        'file.yaml:8: unknown key "weight"',
    ]


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
def test_a_wrong_value_is_replaced_by_a_harmless_one_until_all_is_read(tmp_path, getter, kind):
    for text in ("v: {a: [b]}" if kind is not YamlReader else "v: [1]", "w: 1"):
        reader = read(tmp_path, text)

        value = getter(reader)

        assert isinstance(value, kind)
        if kind not in (YamlReader, list):  # a section or a list need not be there
            assert not reader.is_sound
            with pytest.raises(YamlError):
                reader.finish()


def test_a_wrong_choice_is_said_at_once_with_all_before_it(tmp_path):
    def read_both(reader: YamlReader) -> None:
        reader.get_string("name")
        reader.get_choice("type", SHAPES)

    assert refusal(tmp_path, "type: cube", read_both).splitlines() == [
        'file.yaml:1: the required key "name" is missing',
        'file.yaml:1: type: expected circle or polygon, found "cube"',
    ]


@pytest.mark.parametrize("case", NOT_YAML)
def test_what_is_not_yaml_is_refused_at_its_line(tmp_path, case):
    content, line = NOT_YAML[case]
    path = tmp_path / "file.yaml"
    path.write_bytes(content)

    with pytest.raises(YamlError) as caught:
        YamlReader.from_file(path)

    assert str(caught.value).startswith(f"{path}:{line}: is not valid YAML: ")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        pytest.param(None, "cannot be read: No such file or directory", id="missing"),
        pytest.param(b"", "expected a map, found an empty file", id="empty"),
        pytest.param(b"# nothing\n", "expected a map, found an empty file", id="a comment"),
        pytest.param(b"name: M\xfcller", "is not UTF-8 text: byte 7 is wrong", id="Latin-1"),
    ],
)
def test_an_unusable_file_is_named(tmp_path, content, message):
    path = tmp_path / "file.yaml"
    if content is not None:
        path.write_bytes(content)

    with pytest.raises(YamlError) as caught:
        YamlReader.from_file(path)

    assert str(caught.value) == f"{path}: {message}"


def test_a_second_document_is_refused_at_its_line(tmp_path):
    message = refusal(tmp_path, "a: 1\n---\nb: 2", nothing)

    assert message == "file.yaml:3: expected one document, found another one"


def test_a_directory_is_not_read(tmp_path):
    with pytest.raises(YamlError) as caught:
        YamlReader.from_file(tmp_path)

    assert str(caught.value) == f"{tmp_path}: cannot be read: Is a directory"


def test_a_control_character_is_refused(tmp_path):
    with pytest.raises(YamlError, match="is not valid YAML"):
        read(tmp_path, "name: \x07")


@pytest.mark.parametrize("text", READINGS)
def test_a_value_is_read_as_what_is_asked_for(tmp_path, text):
    getter, expected = READINGS[text]

    assert getter(read(tmp_path, f"v: {text}\n")) == expected


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(tmp_path):
    (tmp_path / "file.yaml").write_bytes(b"\xef\xbb\xbfa: 1\r\nb: two\r\n")

    reader = YamlReader.from_file(tmp_path / "file.yaml")

    assert (reader.get_int("a"), reader.get_string("b")) == (1, "two")


def test_an_alias_stands_for_its_anchor(tmp_path):
    reader = read(tmp_path, "a: &start [1, 2, 3]\nb: *start")

    assert tuple(reader.get_pose("b")) == (1.0, 2.0, 3.0)


def test_keys_that_were_asked_for_are_known_though_they_are_not_given(tmp_path):
    reader = read(tmp_path, "a: 1\nb:\n  - c: 2")
    reader.get_int("a")
    reader.get_string("other", "")

    counts = reader.get_sections("b", lambda section: (section.get_int("c"), section.finish())[0])

    reader.finish()
    assert counts == [2]


def test_an_unknown_key_has_the_line_of_the_key_not_of_its_value(tmp_path):
    def read_models(reader: YamlReader) -> None:
        reader.get_sections("models", nothing)
        reader.finish()

    message = refusal(tmp_path, "modles:\n  - name: robot\n", read_models)

    assert message == 'file.yaml:1: unknown key "modles" (did you mean "models"?)'


def test_whoever_knows_more_than_the_reader_names_problems_at_its_places(tmp_path):
    def read_model(section: YamlReader) -> None:
        section.problem("there is no such body", "body")
        section.problem("is too heavy")
        section.raise_problems()

    text = "models:\n  - name: a\n    body: base"
    message = refusal(tmp_path, text, lambda reader: reader.get_sections("models", read_model))

    assert message.splitlines() == [
        "file.yaml:3: models[0].body: there is no such body",
        'file.yaml:2: models[0] "a": is too heavy',
    ]


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("pose: &pose [*pose]", id="a list that contains itself"),
        pytest.param(f"pose: {'[' * 400}{']' * 400}", id="lists in lists in lists"),
        pytest.param(f"pose: {'[' * 5000}{']' * 5000}", id="lists in lists in ..."),
    ],
)
def test_an_endless_list_is_refused(tmp_path, text):
    (tmp_path / "file.yaml").write_text(text)

    def read_all() -> None:
        reader = YamlReader.from_file(tmp_path / "file.yaml")
        reader.get_pose("pose")
        reader.finish()

    with pytest.raises(YamlError):
        read_all()


def test_a_file_that_nests_too_deeply_does_not_end_the_process(tmp_path):
    program = """
        import sys
        from pathlib import Path
        from flatland_server.exceptions import YamlError
        from flatland_server.yaml_reader import YamlReader
        try:
            YamlReader.from_file(Path(sys.argv[1])).finish()
        except YamlError:
            print("refused")
    """
    path = tmp_path / "file.yaml"
    path.write_text(f"pose: {'[' * 50_000}{']' * 50_000}")

    result = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program), str(path)], stdout=subprocess.PIPE
    )

    assert (result.returncode, result.stdout) == (0, b"refused\n")


GETTERS: Dict[str, Read] = {
    "get_string": lambda r: r.get_string("key"),
    "get_float": lambda r: r.get_float("key", minimum=0.0),
    "get_rate": lambda r: r.get_rate("key"),
    "get_int": lambda r: r.get_int("key"),
    "get_bool": lambda r: r.get_bool("key"),
    "get_choice": lambda r: r.get_choice("key", SHAPES),
    "get_pose": lambda r: r.get_pose("key"),
    "get_points": lambda r: r.get_points("key", 3, 8),
    "get_color": lambda r: r.get_color("key"),
    "get_strings": lambda r: r.get_strings("key"),
    "get_section": lambda r: r.get_section("key").finish(),
    "get_sections": lambda r: r.get_sections("key", lambda section: section.finish()),
    "finish": lambda r: r.finish(),
}
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=2)
    ),
    max_leaves=8,
)


@given(value=VALUES, getter=st.sampled_from(sorted(GETTERS)))
def test_a_getter_gives_a_value_or_a_yaml_error(tmp_path_factory, value, getter):
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_text(yaml.safe_dump({"key": value}, allow_unicode=True), encoding="utf-8")
    reader = YamlReader.from_file(path)

    with contextlib.suppress(YamlError):
        GETTERS[getter](reader)
        reader.finish()


@given(content=st.text() | st.binary())
def test_any_file_gives_a_map_or_a_yaml_error(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "replace"))

    with contextlib.suppress(YamlError):
        YamlReader.from_file(path)

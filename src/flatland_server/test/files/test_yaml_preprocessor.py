"""The preprocessor: includes, and expressions with the documented results."""

import logging
import os
from typing import Any

import pytest
import yaml

from flatland_server.config import composed_files
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import YamlError


@pytest.fixture
def read(files):
    """Reads the text of a file into plain values: `read(text, params)`."""

    def read(text: str, params: Any = None) -> Any:
        params = params or {}
        preprocessor = YamlPreprocessor(lambda path, default: params.get(path, default))
        return plain(preprocessor.read(files.write("parent.yaml", text)))

    return read


def plain(node: yaml.Node) -> Any:
    """The value of a composed node."""
    return yaml.SafeLoader("").construct_object(node, deep=True)


def evaluate(read, expression: str, params: Any = None) -> Any:
    return read(f"foo: $eval {expression}\n", params)["foo"]


# Files that are read again


def test_a_file_is_parsed_again_only_if_it_has_changed(files, read, monkeypatch):
    child = files.write("child.yaml", "a: 1\n")
    text = "foo: $include child.yaml\nbar: $eval param('/x')\n"
    assert read(text, {"/x": 2}) == {"foo": {"a": 1}, "bar": 2}

    with monkeypatch.context() as patch:
        patch.setattr(yaml, "parse", None)
        patch.setattr(yaml, "compose_all", None)
        assert read(text, {"/x": 3}) == {"foo": {"a": 1}, "bar": 3}
    status = child.stat()
    files.write("child.yaml", "a: 9\n")
    os.utime(child, ns=(status.st_atime_ns, status.st_mtime_ns))

    assert read(text) == {"foo": {"a": 9}, "bar": ""}


@pytest.mark.parametrize(("count", "is_kept"), [(100, True), (100_000, False)])
def test_a_file_is_kept_unless_it_is_large(files, count, is_kept):
    path = files.write("file.yaml", f"[{'1, ' * count}]\n")

    first, second = (composed_files.compose_file(path) for _ in range(2))

    assert (first is second) == is_kept


def test_few_files_are_kept(files):
    paths = [files.write(f"{number}.yaml", "[1, 2]\n") for number in range(50)]
    first = composed_files.compose_file(paths[0])
    for path in paths:
        composed_files.compose_file(path)

    assert composed_files.compose_file(paths[0]) is not first


def test_a_kept_file_is_read_again_once_it_has_changed(files):
    first = composed_files.compose_file(files.write("file.yaml", "[1, 2]\n"))
    second = composed_files.compose_file(files.write("file.yaml", "[1, 2, 3]\n"))

    assert (first.value_count, second.value_count) == (3, 4)


# Includes


INCLUDES = {
    "relative and absolute": (
        {"child": "a: 1\nb: 2\n"},
        "foo: 123\nbar: $include child.yaml\nbaz: $include FOLDER/child.yaml\n",
        {"foo": 123, "bar": {"a": 1, "b": 2}, "baz": {"a": 1, "b": 2}},
    ),
    "of several documents in a list": (
        {"child": "one\n---\na: foo\nb: baz\n---\nthree\n"},
        "foo:\n  - first\n  - $[include] child.yaml\n  - last\n",
        {"foo": ["first", "one", {"a": "foo", "b": "baz"}, "three", "last"]},
    ),
    "with a separator that begins no other document": (
        {"child": "one\n---\ntwo\n---\n"},
        "foo:\n  - $[include] child.yaml\n---\n# the end\n",
        {"foo": ["one", "two"]},
    ),
    "relative to its own file": (
        {"parts/wheel": "radius: $include sizes/radius.yaml\n", "parts/sizes/radius": "0.25\n"},
        "wheel: $include parts/wheel.yaml\n",
        {"wheel": {"radius": 0.25}},
    ),
    "of a whole file": ({"child": "a: 1\n"}, "$include child.yaml\n", {"a": 1}),
    "of one document as an item": (
        {"child": "[1, 2]\n"},
        "foo: [$include child.yaml, 3]\n",
        {"foo": [[1, 2], 3]},
    ),
    "twice": ({"child": "1\n"}, "[$include child.yaml, $include child.yaml]\n", [1, 1]),
    "of expressions and includes": (
        {"child": "- $[include] numbers.yaml\n", "numbers": "$eval 1 + 1\n---\n$eval 2 + 1\n"},
        "foo: $include child.yaml\n",
        {"foo": [2, 3]},
    ),
}


@pytest.mark.parametrize(("others", "text", "value"), INCLUDES.values(), ids=INCLUDES)
def test_an_include(files, read, others, text, value):
    for name, content in others.items():
        files.write(f"{name}.yaml", content)

    assert read(text.replace("FOLDER", str(files.folder))) == value


def test_a_cycle_by_a_symbolic_link_is_refused(files, read):
    (files.folder / "other.yaml").symlink_to("parent.yaml")

    with pytest.raises(YamlError) as caught:
        read("foo: $include other.yaml\n")

    assert files.without_folder(str(caught.value)) == "parent.yaml:1: other.yaml includes itself"


def test_a_value_from_an_include_keeps_its_file_and_line(files):
    files.write("child.yaml", "# pose\n\n[1, 2, 3]\n")
    parent = files.write("parent.yaml", "foo: $include child.yaml\n")
    preprocessor = YamlPreprocessor()

    value = preprocessor.read(parent).value[0][1]

    assert value.start_mark.name == str(files.folder / "child.yaml")
    assert value.start_mark.line == 2


@pytest.mark.parametrize("text", ["$included", "$ include a", "a $include b", "$evaluate", "$eval"])
def test_a_string_that_only_resembles_a_keyword_is_kept(read, text):
    assert read(f"foo: '{text}'\n") == {"foo": text}


# Expressions


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("1 + 1", 2),
        ("3 / 2", 1.5),
        ("10 / 2", 5),
        ("2^40", 2**40),
        ("1e-9", 1e-9),
        ("-0.1", -0.1),
        ("math.floor(2.7)", 2),
        ("math.pi", 3.141592653589793),
        ("true", True),
        ("1 > 2", False),
        ("nil", None),
        ("'a' .. 'b'", "ab"),
        ("('x'):rep(3)", "xxx"),
        ("string.upper('lidar')", "LIDAR"),
        ("'5'", "5"),
        ("'true'", "true"),
        ("'# no comment: [x]'", "# no comment: [x]"),
        ("'ünïcode ☃'", "ünïcode ☃"),
        ("{1, 2.5, -3}", [1, 2.5, -3]),
        ("{x = 1, y = {true, 'a'}}", {"x": 1, "y": [True, "a"]}),
        ("{}", []),
        ("#{5, 6, 7}", 3),
        ("table.concat({1, 2}, '-')", "1-2"),
        ("select('#', 1, 2, 3)", 3),
        ("tonumber('0x10')", 16),
        ("type(env)", "function"),
        ("(1 + 2) * 3", 9),
        ("return 4", 4),
        ("local a = 2; return a * a", 4),
    ],
)
def test_an_expression_keeps_the_type_of_its_result(read, expression, value):
    result = read(f"foo: |\n  $eval {expression}\n")["foo"]

    assert result == value
    assert type(result) is type(value)


@pytest.mark.parametrize(("set_to", "value"), [(None, 1.2), ("true", 1.2), ("false", 2.4)])
def test_the_documented_expression_of_several_lines(read, monkeypatch, set_to, value):
    monkeypatch.delenv("FRONT_WHEEL", raising=False)
    if set_to is not None:
        monkeypatch.setenv("FRONT_WHEEL", set_to)

    result = read(
        """
        bar: |  # Multiline string
          $eval  -- $eval flag required to trigger LUA parsing
          if env("FRONT_WHEEL",true) then
            return 1.2
          else
            return 2.4
          end
        """
    )

    assert result == {"bar": value}


def test_the_documented_environment_variable_that_is_not_set(read, monkeypatch, caplog):
    monkeypatch.delenv("SOME_ENV", raising=False)

    assert evaluate(read, 'env("SOME_ENV")') == ""
    assert "parent.yaml:1: the environment variable" in caplog.text
    assert '"SOME_ENV" is not set and has no default; a blank string is used' in caplog.text


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ('env("SOME_ENV", false)', False),
        ('env("SET_ENV")', True),
        ('param("/test/param", 0)/2.0', 0),
        # The documentation says 2.5, which is 5.0 / 2.0 without the 1 that it adds.
        ('param("/set/param", 0)/2.0 + 1', 3.5),
        ('param("/robot").wheels[2] * 2', 0.4),
    ],
)
def test_the_documented_defaults_and_values(read, monkeypatch, caplog, expression, value):
    monkeypatch.delenv("SOME_ENV", raising=False)
    monkeypatch.setenv("SET_ENV", "true")
    params = {"/set/param": 5.0, "/robot": {"wheels": [0.1, 0.2]}}

    assert evaluate(read, expression, params) == value
    assert caplog.text == ""


def test_the_documented_blank_of_a_parameter_that_is_not_set(read, caplog):
    assert evaluate(read, 'param("/test/param")') == ""
    assert 'the parameter "/test/param" is not set and has no default' in caplog.text
    assert caplog.records[0].levelno == logging.WARNING


@pytest.mark.parametrize(
    ("text", "value"),
    [("1.5", 1.5), ("7", 7), ("false", False), ("True", "True"), ("", ""), ("nan", "nan")],
)
def test_an_environment_variable_becomes_a_bool_number_or_string(read, monkeypatch, text, value):
    monkeypatch.setenv("SOME_ENV", text)

    result = evaluate(read, 'env("SOME_ENV", 1)')

    assert result == value
    assert type(result) is type(value)


@pytest.mark.parametrize(
    "value", [True, 3, 2.5, "a string", ["a", 1, [2]], {"x": 1, "y": {"z": [1, 2]}}, [], ""]
)
def test_a_parameter_comes_back_as_it_was_set(read, value):
    assert evaluate(read, 'param("/p")', {"/p": value}) == value


def test_the_enabled_flag_follows_an_expression(good_files, monkeypatch):
    monkeypatch.setenv("WITH_LASER", "false")
    good_files.edit(
        "robot.model.yaml", "name: laser", 'name: laser\n    enabled: $eval env("WITH_LASER")'
    )

    world = good_files.load()

    assert list(world.plugins_of("robot")) == ["drive"]
    world.close()


def test_an_expression_cannot_access_the_variables_of_another(read):
    with pytest.raises(YamlError, match='"y" is not available in'):
        read('a: "$eval y = 1; return y"\nb: $eval y\n')


def test_the_error_of_a_failing_expression_has_its_place(files, read):
    files.write("child.yaml", "a: 1\nb: $eval nothing.at.all\n")

    with pytest.raises(YamlError) as caught:
        read("foo: $include child.yaml\n")

    assert files.without_folder(str(caught.value)) == (
        'child.yaml:2: $eval: "nothing" is not available in $eval, in: nothing.at.all'
    )

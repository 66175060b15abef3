"""YamlReader: a file that is missing, not YAML or not a map is refused; any YAML syntax is read."""

import subprocess
import sys
import textwrap

import pytest
from yaml_reader.reading import nothing, read, refusal

from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import YamlError

WRONG_STRUCTURES = {
    "a key given twice": ("mass: 1\nmass: 2", '2: the key "mass" is given twice'),
    "a list as a key": ("[a]: 1", '1: expected a key, found ["a"]'),
    "a list for the whole": ("# robots\n- a\n- b", '2: expected a map, found ["a", "b"]'),
    "a string for the whole": ("hello", '1: expected a map, found "hello"'),
}

NOT_YAML = {
    "a tab": (b"models:\n\t- name: a", 2),
    "an open bracket": (b"a: 1\npose: [0, 0\nname: x", 3),
    "an unknown alias": (b"a: *robot", 1),
    "bad indentation": (b"a:\n    b: 1\n  c: 2", 3),
}


@pytest.mark.parametrize("case", WRONG_STRUCTURES)
def test_a_wrong_structure_is_named_with_its_line(tmp_path, case):
    text, message = WRONG_STRUCTURES[case]

    assert refusal(tmp_path, text, nothing) == f"file.yaml:{message}"


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


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(tmp_path):
    (tmp_path / "file.yaml").write_bytes(b"\xef\xbb\xbfa: 1\r\nb: two\r\n")

    reader = YamlReader.from_file(tmp_path / "file.yaml")

    assert (reader.get_int("a"), reader.get_string("b")) == (1, "two")


def test_an_alias_stands_for_its_anchor(tmp_path):
    reader = read(tmp_path, "a: &start [1, 2, 3]\nb: *start")

    assert tuple(reader.get_pose("b")) == (1.0, 2.0, 3.0)


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
        from flatland_server.config.yaml_reader import YamlReader
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

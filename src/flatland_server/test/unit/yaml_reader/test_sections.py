"""YamlReader: sections of a map, and the entries of a list."""

import pytest
from yaml_reader.reading import SHAPES, nothing, read, refusal

from flatland_server.config.yaml_reader import YamlReader


def read_name(entry: YamlReader) -> str:
    name = entry.get_string("name")
    entry.finish()
    return name


# Sections


@pytest.mark.parametrize(
    ("text", "message"),
    [
        pytest.param("a: 1", '1: the required key "shape" is missing', id="missing"),
        pytest.param("shape: cube", '1: shape: expected a map, found "cube"', id="not a map"),
        pytest.param("shape: {[a]: 1}", '1: shape: expected a key, found ["a"]', id="a wrong key"),
    ],
)
def test_a_wrong_section_has_no_further_problems(tmp_path, text, message):
    def read_section(reader: YamlReader) -> None:
        section = reader.get_section("shape", required=True)
        section.get_float("radius")
        section.problem("is too small")
        section.finish()

    assert refusal(tmp_path, text, read_section) == f"file.yaml:{message}"


def test_a_choice_in_a_missing_section_names_the_section(tmp_path):
    def read_section(reader: YamlReader) -> None:
        reader.get_section("shape", required=True).get_choice("type", SHAPES)

    message = refusal(tmp_path, "a: 1", read_section)

    assert message == 'file.yaml:1: the required key "shape" is missing'


def test_a_section_leaves_it_to_its_map_to_raise(tmp_path):
    reader = read(tmp_path, "shape: {radius: wide}")
    section = reader.get_section("shape")
    section.get_float("radius")

    section.finish()

    assert not reader.is_sound
    assert not section.is_sound


# Entries


def test_an_entry_knows_only_its_own_problems(tmp_path):
    soundness = []

    def read_entry(entry: YamlReader) -> None:
        entry.get_string("name")
        soundness.append(entry.is_sound)
        entry.finish()

    reader = read(tmp_path, "bodies:\n  - {}\n  - {name: wheel}")
    reader.get_sections("bodies", read_entry)

    assert soundness == [False, True]
    assert not reader.is_sound


def test_problems_of_an_unfinished_entry_are_reported(tmp_path):
    text = "bodies:\n  - {name: base, name: wheel}"

    message = refusal(tmp_path, text, lambda reader: reader.get_sections("bodies", nothing))

    assert message == 'file.yaml:2: bodies[0]: the key "name" is given twice'


def test_an_error_of_an_entry_includes_its_earlier_problems(tmp_path):
    def read_entry(entry: YamlReader) -> None:
        entry.get_string("name")
        raise entry.error("expected two wheels")

    message = refusal(tmp_path, "bodies: [{}]", lambda r: r.get_sections("bodies", read_entry))

    assert message.splitlines() == [
        'file.yaml:1: bodies[0]: the required key "name" is missing',
        "file.yaml:1: bodies[0]: expected two wheels",
    ]


def test_an_entry_that_is_kept_can_be_read_later(tmp_path):
    reader = read(tmp_path, "plugins: [{name: laser, range: far}]")
    [entry] = reader.get_sections("plugins", lambda section: section)
    reader.finish()

    entry.get_string("name")
    entry.get_float("range")

    assert not entry.is_sound
    assert reader.is_sound


# Entries that can be switched off


def test_a_disabled_entry_is_skipped_whatever_it_contains_and_its_name_is_free(tmp_path):
    off = ("{enabled: false, name: [a], name: [b], mass: heavy}", "{name: base, enabled: no}")
    text = "\n  - ".join(["bodies:", *off, "{name: base, enabled: yes}"])
    reader = read(tmp_path, text)

    names = reader.get_enabled_sections("bodies", read_name)

    reader.finish()
    assert names == ["base"]


def test_two_enabled_entries_may_not_have_the_same_name(tmp_path):
    text = "bodies:\n  - {name: base}\n  - {name: base}"

    message = refusal(tmp_path, text, lambda r: r.get_enabled_sections("bodies", read_name))

    assert message == 'file.yaml:3: bodies[1].name: the name "base" is given twice'

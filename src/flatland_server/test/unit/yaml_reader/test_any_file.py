"""YamlReader: a file with any content is read, or refused with a YamlError."""

import contextlib
from typing import Dict

import yaml
from hypothesis import given
from hypothesis import strategies as st
from yaml_reader.reading import SHAPES, Read

from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import YamlError

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

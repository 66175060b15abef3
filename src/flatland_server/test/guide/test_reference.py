"""The reference agrees with the code: keys, arguments, definitions."""

import importlib
import re

import pytest
import reference_tables
import samples
from page_run import ROOT

from flatland_server import arrays, exceptions

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def marks():
    """The subjects of the generated tables of all pages, as their marks name them."""
    pages = [page.read_text(encoding="utf-8") for page in reference_tables.pages()]
    return {match[2] for page in pages for match in reference_tables.MARK.finditer(page)}


@pytest.mark.parametrize(
    "page",
    [p for p in reference_tables.pages() if "<!-- " in p.read_text(encoding="utf-8")],
    ids=lambda page: str(page.relative_to(DOCS)),
)
def test_the_generated_parts_of_a_page_are_those_of_the_code(page):
    text = page.read_text(encoding="utf-8")

    assert reference_tables.updated(text) == text, "run scripts/docs --update"
    assert reference_tables.problems(text) == []


@pytest.mark.parametrize("name", samples.plugin_names())
def test_all_keys_of_a_plugin_are_on_the_page(name, marks):
    keys = set(samples.keys_of_plugin(name))
    if f"plugin {name}" in marks:
        return
    if any(mark.startswith(f"plugin {name} beyond ") for mark in marks):
        return

    assert keys <= set(samples.keys_of_plugin("DiffDrive"))


@pytest.mark.parametrize("kind", list(samples.MAPS))
def test_all_keys_of_a_file_are_on_the_pages(kind, marks):
    """A plugin's entry is described once, with worlds."""
    sections = {key.name.rpartition("[].")[0] for key in samples.keys_of_file(kind)}
    expected = {f"{kind} {section}[]" if section else kind for section in sections}

    assert expected - {"model plugins[]"} - marks == set()


@pytest.fixture
def fresh_keys():
    """Clears the cache of plugins' keys before and after a test."""
    samples.keys_of_plugin.cache_clear()
    yield
    samples.keys_of_plugin.cache_clear()


@pytest.mark.usefixtures("fresh_keys")
def test_a_default_that_changes_in_the_code_is_noticed(monkeypatch):
    from flatland_plugins import laser_config

    read = laser_config.LaserConfig.read.__func__

    def with_another_default(cls, config, *rest):
        config.get_topic("topic", "another_scan")
        return read(cls, config, *rest)

    monkeypatch.setattr(laser_config.LaserConfig, "read", classmethod(with_another_default))
    text = (DOCS / "reference" / "plugins.md").read_text(encoding="utf-8")

    assert reference_tables.updated(text) != text


@pytest.fixture(scope="module")
def documented():
    """The objects on the pages of the Python API, by their full names."""
    folder = DOCS / "reference" / "python"
    text = "".join(page.read_text(encoding="utf-8") for page in folder.glob("*.md"))
    shown = set(re.findall(r"^::: (\S+)$", text, re.MULTILINE))
    for module in (arrays, exceptions):  # each is shown as a whole
        assert module.__name__ in shown
        shown |= {f"flatland_server.{name}" for name in vars(module)}
    return shown | {name.replace("._core.", ".") for name in shown}


@pytest.mark.parametrize(
    "package", ["flatland2d", "flatland_server", "flatland_server.testing", "flatland_gym"]
)
def test_each_public_name_is_on_a_page_of_the_python_api(package, documented):
    names = set(importlib.import_module(package).__all__)

    missing = {
        name for name in names if not {f"{package}.{name}", f"flatland_server.{name}"} & documented
    }

    assert missing <= {"messages"}  # its page shows only the functions that plugins use


def test_each_name_that_docs_import_is_in_the_python_api_pages(documented):
    told = set()
    for file in [*DOCS.rglob("*.md"), ROOT / "README.md", *(ROOT / "examples").rglob("*.py")]:
        text = file.read_text(encoding="utf-8")
        for module, names in re.findall(r"^from (flatland_\S+\.\S+) import (.+)$", text, re.M):
            told |= {f"{module}.{name}" for name in re.findall(r"\w+", names)}
    told = {name for name in told if not name.startswith("flatland_msgs.")}

    assert "flatland_navigation.grid.Grid" in told
    assert told - documented == set()

"""The reference is what the code says: keys, arguments, definitions, figures."""

import inspect
import re

import figures
import pytest
import reference_tables
import samples
from page_run import ROOT

import flatland_server
from flatland_server import exceptions

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def marks():
    """What the tables of all pages are of."""
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
    shared = set(samples.keys_of_plugin("DiffDrive")) if keys else set()

    assert f"plugin {name} beyond DiffDrive" in marks or keys <= shared


@pytest.mark.parametrize("kind", list(samples.MAPS))
def test_all_keys_of_a_file_are_on_the_pages(kind, marks):
    """A plugin's entry is described once, with worlds."""
    sections = {key.name.rpartition("[].")[0] for key in samples.keys_of_file(kind)}
    expected = {f"{kind} {section}[]" if section else kind for section in sections}

    assert expected - {"model plugins[]"} - marks == set()


@pytest.fixture
def fresh_keys():
    """The keys are read again: what was read before is not used, and is not kept."""
    samples.keys_of_plugin.cache_clear()
    yield
    samples.keys_of_plugin.cache_clear()


@pytest.mark.usefixtures("fresh_keys")
def test_a_default_that_changes_in_the_code_is_noticed(monkeypatch):
    from flatland_plugins import laser_config

    read = laser_config.LaserConfig.read.__func__

    def with_another_default(cls, config, name):
        config.get_topic("topic", "another_scan")
        return read(cls, config, name)

    monkeypatch.setattr(laser_config.LaserConfig, "read", classmethod(with_another_default))
    text = (DOCS / "reference" / "plugins.md").read_text(encoding="utf-8")

    assert reference_tables.updated(text) != text


def test_each_public_name_is_on_a_page_of_the_python_api():
    """Exceptions are documented as a module; constants and type aliases are not classes."""
    folder = DOCS / "reference" / "python"
    shown = "".join(page.read_text(encoding="utf-8") for page in folder.glob("*.md"))
    values = {name: getattr(flatland_server, name) for name in flatland_server.__all__}
    names = [
        name
        for name, value in values.items()
        if (inspect.isclass(value) or inspect.isfunction(value))
        and value.__module__.startswith("flatland_server")
    ]

    missing = [
        name
        for name in names
        if not hasattr(exceptions, name) and not re.search(rf"^::: .*\.{name}$", shown, re.M)
    ]

    assert len(names) > 60
    assert "::: flatland_server.exceptions" in shown
    assert missing == []


def test_the_figures_are_those_that_the_code_makes():
    assert figures.outdated() == [], "run scripts/docs --update"

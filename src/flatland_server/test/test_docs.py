"""Statements of the docs about the code are true. Their blocks are run in test/guide."""

import importlib
import re
from pathlib import Path

import pytest
import samples

from flatland_server import _core, testing
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.models.entity import Entity
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.node import Node
from flatland_server.transport.transport import Publisher

DOCS = Path(__file__).resolve().parents[3] / "docs"
PLUGINS = DOCS / "reference" / "plugins.md"
PAGES = [DOCS / "plugins.md", *(DOCS / "plugins").glob("*.md"), PLUGINS]
PYTHON_FILE = re.compile(r"```python\n# file: (\S+)\n(.*?)```", re.DOTALL)


def sections():
    """The text of the pages of plugins by headings, among them the plugins' names."""
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    text = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    parts = re.split(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


class Listener(LocalTransport):
    """Notes the type of each topic."""

    def __init__(self):
        super().__init__()
        self.types = {}

    def advertise(self, topic, message_type, **options):
        self.types[topic] = message_type._type
        return super().advertise(topic, message_type, **options)

    def subscribe(self, topic, message_type, callback):
        self.types[topic] = message_type._type
        return super().subscribe(topic, message_type, callback)


@pytest.mark.parametrize(
    ("heading", "classes"),
    [
        ("Life cycle", [Plugin]),
        ("Configuration", [YamlReader]),
        ("Topics, transforms and parameters", [Node]),
        ("Bodies", [_core.Body]),
        ("Testing a plugin", [testing, testing.Harness]),
        ("Contacts", [ModelPlugin, Entity, _core.Contact, _core.ContactImpulse]),
    ],
)
def test_names_in_the_tables_exist_in_the_code(heading, classes):
    cells = re.findall(r"^\| (`.*?) \|", sections()[heading], flags=re.MULTILINE)
    names = [name for cell in cells for name in re.findall(r"`(?:\w+\.)?(\w+)", cell)]

    known = {"node", "old_manifold", "timekeeper", "transport", "world"}.union(
        *(dir(each) for each in classes)
    )
    assert len(names) >= len(cells) > 5
    assert [name for name in names if name not in known] == []


@pytest.mark.parametrize("name", samples.plugin_names())
def test_a_plugin_publishes_and_subscribes_what_its_section_says(name):
    said = sections()[name]
    if "[DiffDrive](#diffdrive)" in said:  # the keys shared with DiffDrive are described there
        said += sections()["DiffDrive"]
    transport = Listener()
    files = testing.WorldFiles()
    files.walls("walls", *samples.WALLS)
    files.write("people.csv", "0,1,1,1\n25,1,2,1\n")
    of_world = samples.is_of_the_world(name)
    plugins = [{"type": name, "name": name.lower(), **samples.PLUGINS[name][-1]}]
    files.write("robot.model.yaml", {**samples.TRICYCLE, "plugins": [] if of_world else plugins})
    world = {
        "properties": {},
        "layers": [{"name": "map", "map": "walls.yaml"}],
        "models": [{"name": "robot", "model": "robot.model.yaml"}],
        "plugins": plugins if of_world else [],
    }

    files.load(world, transport=transport).run()

    for topic, type in transport.types.items():
        assert re.sub("(crowd|jointmotor)/", "<name>/", topic) in said
        assert f"`{type}`" in said
    for transform in transport.transforms.values():
        assert f"`{transform.parent}`" in said
        assert f"`{transform.child}`" in said


# docs/coming_from_cpp.md


MIGRATION = DOCS / "coming_from_cpp.md"


def test_the_plugin_that_was_one_in_cpp_works(tmp_path, monkeypatch):
    text = MIGRATION.read_text(encoding="utf-8")
    [(name, source)] = PYTHON_FILE.findall(text)
    assert text.count("```python") == 1
    (tmp_path / name).write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    declaration = PluginDeclaration.of(importlib.import_module(Path(name).stem).Speedometer)
    files = testing.WorldFiles(tmp_path, PluginLoader([declaration]))
    plugin = "type: Speedometer, name: speedometer, body: base"

    simulation = files.robot(plugin)
    simulation.model().bodies["base"].physics_body.velocity = (0.3, 0.4, 0.0)
    messages = simulation.record("/speed", 1.0)

    assert len(messages) == 10
    assert messages[-1].data == pytest.approx(0.5, abs=1e-6)


def test_each_python_replacement_of_a_cpp_call_exists():
    text = MIGRATION.read_text(encoding="utf-8")
    rows = re.findall(r"^\| `.*?\| (.*) \|$", text.partition("| C++ |")[2], flags=re.MULTILINE)
    owners = {
        "config": YamlReader,
        "self": ModelPlugin,
        "node": Node,
        "physics": _core.Body,
        "publisher": Publisher,
        "timekeeper": Timekeeper(0.005),
        "contact": _core.Contact,
        "lidar": _core.Lidar,
    }

    named = [pair for row in rows for pair in re.findall(r"\b(\w+)\.(\w+)", row)]
    checked = [(owner, name) for owner, name in named if owner in owners]
    getters = [name for row in rows for name in re.findall(r"`(get_\w+)", row)]
    assert len(checked) >= 20
    assert len(getters) >= 10
    attributes = {"self": {"name", "type", "node", "model", "update_timer", "_callback"}}
    missing = [
        f"{owner}.{name}"
        for owner, name in checked
        if not hasattr(owners[owner], name) and name not in attributes.get(owner, ())
    ]
    assert missing + [name for name in getters if not hasattr(YamlReader, name)] == []


# docs/robustness.md


def test_each_promise_of_robustness_names_a_test_that_exists():
    text = (DOCS / "robustness.md").read_text(encoding="utf-8")
    files = list((DOCS.parent / "src").glob("*/test/**/test_*.py"))
    functions = {
        name
        for path in files
        for name in re.findall(r"^def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    }

    named = re.findall(r"`((?:\w+/)*test_\w+(?:\.py)?)`", text)
    missing = [
        name
        for name in named
        if name not in functions and not any(str(path).endswith(f"/{name}") for path in files)
    ]

    assert len(named) > 10
    assert missing == []

"""What the pages of docs say is so: each of their blocks is loaded or run."""

import importlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from PIL import Image

from flatland_server import _core, testing
from flatland_server.config.yaml_reader import REQUIRED, YamlReader
from flatland_server.models.collision_filter_registry import AnyLayer
from flatland_server.models.entity import Entity
from flatland_server.models.model import ModelConfig
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.node import Node, Publisher

DOCS = Path(__file__).resolve().parents[3] / "docs"
PAGE = DOCS / "files.md"
BLOCK = re.compile(r"```yaml\n# file: (\S+)\n(.*?)```", re.DOTALL)


@pytest.fixture
def folder(tmp_path):
    """The page's files, and those that they name."""
    for name, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    Image.new("L", (200, 200), 0).save(tmp_path / "map.png")
    (tmp_path / "lines.dat").write_text("-5 0 5 0\n")
    footprint = "{type: circle, radius: 0.1, density: 1}"
    (tmp_path / "bodies.yaml").write_text(
        f"{{name: base_link, footprints: [{footprint}]}}\n---\n"
        f"{{name: arm, footprints: [{footprint}]}}\n"
    )
    (tmp_path / "tower_footprints.yaml").write_text(f"[{footprint}]\n")
    return tmp_path


def test_every_yaml_block_is_one_of_the_files():
    text = PAGE.read_text(encoding="utf-8")
    assert len(BLOCK.findall(text)) == text.count("```yaml")


def test_the_world_of_the_page_loads(folder):
    world = World.from_file(folder / "world.yaml")

    assert [layer.name for layer in world.layers] == ["map", "walls_3d", "reflectance"]
    assert [len(layer.segments) for layer in world.layers] == [4, 1, 0]
    assert list(world.models["robot1"].bodies) == ["base_link", "caster"]
    assert world.plugin_count == 2


def test_the_parametric_model_of_the_page_loads(folder, monkeypatch):
    monkeypatch.setenv("SLOW", "true")
    model = ModelConfig.from_file(folder / "parametric.model.yaml", AnyLayer())

    assert [body.name for body in model.bodies] == ["base_link", "arm"]
    limits = model.plugins[0].reader.get_section("linear_dynamics")
    assert limits.get_float("velocity_limit") == 0.75
    assert limits.get_float("acceleration_limit") == 0.5


# docs/plugins.md


PLUGINS = DOCS / "plugins.md"
EXAMPLES = DOCS.parent / "src" / "flatland_example_plugins"
FRAGMENT = re.compile(r"```yaml\n# in (\S+)\n(.*?)```", re.DOTALL)
PYTHON_FILE = re.compile(r"```python\n# file: (\S+)\n(.*?)```", re.DOTALL)
EXCERPT = re.compile(r"```(?:python|xml)\n(?!# file)(.*?)```", re.DOTALL)
DECLARATIONS = ElementTree.parse(PLUGINS.parents[1] / "src/flatland_plugins/flatland_plugins.xml")


def sections():
    """The page's text by its headings, among them the plugins' names."""
    parts = re.split(r"^###? (.+)$", PLUGINS.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


@pytest.fixture
def plugin_folder(tmp_path):
    """The files of docs/plugins.md, in a room with walls."""
    for name, text in BLOCK.findall(PLUGINS.read_text(encoding="utf-8")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "walls.yaml").write_text(
        "{type: line_segments, data: walls.dat, scale: 1, origin: [0, 0, 0]}"
    )
    (tmp_path / "walls.dat").write_text("-9 -9 9 -9\n9 -9 9 9\n9 9 -9 9\n-9 9 -9 -9\n")
    return tmp_path


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


class Reading(NamedTuple):
    """What a plugin has read at a key that is given."""

    key: str
    comment: str
    value: Any
    default: Any


@pytest.fixture
def readings(monkeypatch):
    """What plugins read: the keys that are given, and the names of those that are not."""
    given, missing = [], set()
    get = YamlReader._value

    def note(reader, key, default, convert):
        value = get(reader, key, default, convert)
        if reader.path.startswith("plugins[") and key not in ("type", "name", "enabled"):
            if reader.has(key):
                mark = reader._values[key].start_mark
                line = Path(mark.name).read_text(encoding="utf-8").splitlines()[mark.line]
                given.append(Reading(key, line.partition("#")[2], value, default))
            else:
                missing.add(key)
        return value

    monkeypatch.setattr(YamlReader, "_value", note)
    return given, missing


def test_every_block_of_the_plugins_page_is_tested():
    text = PLUGINS.read_text(encoding="utf-8")

    tested = [
        r for pattern in (BLOCK, FRAGMENT, PYTHON_FILE, EXCERPT) for r in pattern.findall(text)
    ]
    assert len(tested) == sum(
        text.count(f"```{language}") for language in ("yaml", "python", "xml")
    )


@pytest.mark.parametrize(
    "excerpt",
    EXCERPT.findall(PLUGINS.read_text(encoding="utf-8")),
    ids=lambda excerpt: excerpt.split()[1],
)
def test_what_the_page_shows_of_the_example_package_is_in_it(excerpt):
    files = [path for path in EXAMPLES.rglob("*") if path.suffix in (".py", ".xml")]

    assert any(excerpt in path.read_text(encoding="utf-8") for path in files)


@pytest.mark.parametrize(
    ("heading", "classes"),
    [
        ("Life cycle", [Plugin]),
        ("Configuration", [YamlReader]),
        ("Topics, transforms and parameters", [Node]),
        ("Bodies", [_core.Body]),
        ("Testing a plugin", [testing, testing.Simulation]),
        ("Contacts", [ModelPlugin, Entity, _core.Contact, _core.ContactImpulse]),
    ],
)
def test_the_tables_name_what_there_is(heading, classes):
    cells = re.findall(r"^\| (`.*?) \|", sections()[heading], flags=re.MULTILINE)
    names = [name for cell in cells for name in re.findall(r"`(?:\w+\.)?(\w+)", cell)]

    known = {"node", "old_manifold", "timekeeper", "world"}.union(*(dir(each) for each in classes))
    assert len(names) >= len(cells) > 5
    assert [name for name in names if name not in known] == []


def test_the_model_with_a_plugin_of_ones_own_loads(plugin_folder):
    config = plugin_folder / "world.yaml"
    config.write_text(
        "properties: {}\nlayers: []\nmodels: [{name: a, model: drifter.model.yaml}]\n"
    )

    assert World.from_file(config).plugin_count == 1


@pytest.mark.parametrize("name", [each.get("name") for each in DECLARATIONS.iter("class")])
def test_a_plugin_is_as_the_page_says(plugin_folder, readings, name):
    section = sections()[name]
    [(file, fragment)] = FRAGMENT.findall(section)
    with (plugin_folder / file).open("a", encoding="utf-8") as whole:
        whole.write(fragment)
    transport = Listener()

    world = World.from_file(plugin_folder / "world.yaml", transport)
    world.step(Timekeeper(0.005))

    given, missing = readings
    for key, comment, value, default in given:
        if "required" in comment:
            assert default is REQUIRED, key
        else:
            assert value == default or "example" in comment, key
    # What it shares with DiffDrive is said there.
    said = section + sections()["DiffDrive"] if "[DiffDrive](#diffdrive)" in section else section
    assert [key for key in missing if not re.search(rf"\b{key}\b", said)] == []
    for topic, type in transport.types.items():
        assert topic in said
        assert f"`{type}`" in said
    for transform in transport.transforms.values():
        assert f"`{transform.parent}`" in said
        assert f"`{transform.child}`" in said


def test_the_program_of_the_page_runs(plugin_folder):
    programs = dict(PYTHON_FILE.findall(PLUGINS.read_text(encoding="utf-8")))
    name = "try_it.py"
    (plugin_folder / name).write_text(programs[name], encoding="utf-8")
    [(file, drive)] = FRAGMENT.findall(sections()["DiffDrive"])
    with (plugin_folder / file).open("a", encoding="utf-8") as model:
        model.write(drive)

    result = subprocess.run(
        [sys.executable, name], cwd=plugin_folder, stdout=subprocess.PIPE, text=True, check=True
    )

    assert "Pose(x=1.0" in result.stdout


def test_the_tests_of_the_page_pass():
    namespace = {}
    exec(dict(PYTHON_FILE.findall(PLUGINS.read_text(encoding="utf-8")))["test_robot.py"], namespace)

    tests = [each for name, each in namespace.items() if name.startswith("test_")]
    assert len(tests) == 2
    for test in tests:
        test()


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


def test_the_twins_of_cpp_calls_exist():
    text = MIGRATION.read_text(encoding="utf-8")
    rows = re.findall(r"^\| `.*?\| (.*) \|$", text.partition("| C++ |")[2], flags=re.MULTILINE)
    owners = {
        "config": YamlReader,
        "self": ModelPlugin,
        "node": Node,
        "physics": _core.Body,
        "publisher": Publisher,
        "timekeeper": Timekeeper,
        "contact": _core.Contact,
        "lidar": _core.Lidar,
    }

    named = [pair for row in rows for pair in re.findall(r"\b(\w+)\.(\w+)", row)]
    checked = [(owner, name) for owner, name in named if owner in owners]
    getters = [name for row in rows for name in re.findall(r"`(get_\w+)", row)]
    assert len(checked) >= 25
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

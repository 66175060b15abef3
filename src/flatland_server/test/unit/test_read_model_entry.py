"""Spawning in two parts: reading on any thread, and adding on the simulation's."""

import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from flatland_server.exceptions import ModelError, YamlError
from flatland_server.geometry import Pose
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader

EMPTY_WORLD = "{properties: {}, layers: []}"
MODEL = "bodies: [{name: base, footprints: [{type: circle, radius: 0.2, density: 1}]}]\n"
POSE = Pose(1.0, 2.0, 0.5)


def test_reading_changes_nothing(files):
    world = files.load(EMPTY_WORLD)
    path = files.write("model.yaml", MODEL)

    entry = world.read_model_entry(path, "robot", "ns", POSE)

    assert (entry.name, entry.namespace, entry.pose) == ("robot", "ns", POSE)
    assert (world.models, world.physics.body_count) == ({}, 0)
    world.add_model(entry)
    assert world.get_model("robot").pose == pytest.approx(POSE)


def test_the_second_entry_of_a_name_is_refused(files):
    world = files.load(EMPTY_WORLD)
    path = files.write("model.yaml", MODEL)
    with ThreadPoolExecutor(2) as pool:
        read = lambda _: world.read_model_entry(path, "robot", "", POSE)  # noqa: E731
        entries = list(pool.map(read, range(2)))

    world.add_model(entries[0])
    with pytest.raises(ModelError, match='a model named "robot" is already there'):
        world.add_model(entries[1])

    assert list(world.models) == ["robot"]


def test_plugin_classes_are_imported_by_reading(files, tmp_path, monkeypatch):
    (tmp_path / "imported_late.py").write_text(
        "from flatland_server.plugins.model_plugin import ModelPlugin\n"
        "class Late(ModelPlugin):\n"
        "    def on_initialize(self, config): pass\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    loader = PluginLoader([PluginDeclaration("Late", "tests", "imported_late.Late")])
    world = files.load(EMPTY_WORLD, loader=loader)
    path = files.write("model.yaml", MODEL + "plugins: [{type: Late, name: late}]")
    assert "imported_late" not in sys.modules

    entry = world.read_model_entry(path, "robot", "", POSE)

    assert "imported_late" in sys.modules
    world.add_model(entry)
    del sys.modules["imported_late"]


def test_adding_a_model_reports_an_unknown_plugin_with_its_line(files):
    world = files.load(EMPTY_WORLD)
    path = files.write("model.yaml", MODEL + "plugins:\n- {type: Lazer, name: laser}")

    entry = world.read_model_entry(path, "robot", "", POSE)

    with pytest.raises(YamlError, match=r'model\.yaml:3: .*unknown plugin type "Lazer"'):
        world.add_model(entry)

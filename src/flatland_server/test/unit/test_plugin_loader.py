"""Plugins are found by their type in the packages on ROS_PACKAGE_PATH."""

import sys
import tracemalloc
from pathlib import Path
from typing import Iterator

import pytest
from logged import warnings

from flatland_server.exceptions import PluginError
from flatland_server.plugins import plugin_loader
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.simulation.world import WorldPlugin

MODULE = """
from flatland_server.plugins.model_plugin import ModelPlugin
class {name}(ModelPlugin):
    pass
"""


class Packages:
    """ROS packages in a folder that is the whole ROS_PACKAGE_PATH and on sys.path."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def add(self, package: str, plugins_xml: str, *, package_xml: str = "", **modules: str) -> None:
        """Writes a package; the names of its modules begin with loader_."""
        prefix = self.folder / package
        prefix.mkdir()
        export = '<export><flatland_server plugin="${prefix}/plugins.xml"/></export>'
        (prefix / "package.xml").write_text(
            package_xml or f"<package format='3'><name>{package}</name>{export}</package>"
        )
        (prefix / "plugins.xml").write_text(plugins_xml)
        for module, text in modules.items():
            (self.folder / f"{module}.py").write_text(text)

    def add_plugin(self, package: str, name: str, module: str, text: str = MODULE) -> None:
        """Writes a package with one plugin; with the text of its module."""
        xml = f'<library><class name="{name}" type="{module}.{name}"/></library>'
        self.add(package, xml, **{module: text.format(name=name)})


@pytest.fixture
def packages(tmp_path, monkeypatch) -> Iterator[Packages]:
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    monkeypatch.syspath_prepend(str(tmp_path))
    yield Packages(tmp_path)
    for name in [name for name in sys.modules if name.startswith("loader_")]:
        del sys.modules[name]


def refusal(type: str, base: type = ModelPlugin) -> str:
    """The error when a plugin is loaded."""
    with pytest.raises(PluginError) as caught:
        PluginLoader().load(type, base)
    return str(caught.value)


@pytest.mark.parametrize("type", ["DiffDrive", "flatland_plugins::DiffDrive"])
def test_built_in_plugins_are_found_with_or_without_package(type):
    from flatland_plugins.diff_drive import DiffDrive

    assert PluginLoader().load(type, ModelPlugin) is DiffDrive


@pytest.mark.parametrize("namespace", ["", "my_plugins::", "my_namespace::inner::"])
def test_a_plugin_is_found_with_the_namespace_that_is_declared(packages, namespace):
    """As those of C++, which are not always named like their packages."""
    names = ("my_namespace::inner::Thing", "my_namespace::other::Other", "loader/Slash")
    classes = [
        f'<class name="{each}" type="loader_things.{each.replace("/", "::").rpartition("::")[2]}"/>'
        for each in names
    ]
    text = "".join(MODULE.format(name=name) for name in ("Thing", "Other", "Slash"))
    packages.add("my_plugins", f"<library>{''.join(classes)}</library>", loader_things=text)

    assert PluginLoader().load(f"{namespace}Thing", ModelPlugin).__name__ == "Thing"
    assert PluginLoader().load("my_namespace::other::Other", ModelPlugin).__name__ == "Other"
    assert PluginLoader().load("loader::Slash", ModelPlugin).__name__ == "Slash"
    assert "unknown plugin type" in refusal("my_namespace::Thing")
    assert "unknown plugin type" in refusal("my_namespace::other::Thing")


@pytest.mark.parametrize("package", ["", "flatland_plugins::"])
def test_an_alias_of_a_plugin_yields_to_a_package(packages, package):
    xml = '<class name="{0}" type="flatland_plugins.{1}.{0}"/>'
    publisher = xml.format("PosePublisher", "pose_publisher")
    pedestrian = xml.format("Pedestrian", "pedestrian")
    packages.add("flatland_plugins", f"<library>{publisher}{pedestrian}</library>")

    assert PluginLoader().load(f"{package}PosePub", ModelPlugin).__name__ == "PosePublisher"
    assert PluginLoader().load(f"{package}PedsimMovement", ModelPlugin).__name__ == "Pedestrian"
    packages.add_plugin("my_plugins", "PosePub", "loader_own")
    assert PluginLoader().load("PosePub", ModelPlugin).__module__ == "loader_own"


@pytest.mark.parametrize("name", ["", 'name="my_plugins/Pusher"'])
def test_the_name_of_a_declaration_may_be_left_out_or_have_its_package(packages, name):
    """As in pluginlib."""
    xml = f'<library><class {name} type="loader_pushes.Pusher"/></library>'
    packages.add("my_plugins", xml, loader_pushes=MODULE.format(name="Pusher"))

    for type in ("Pusher", "my_plugins::Pusher"):
        assert PluginLoader().load(type, ModelPlugin).__name__ == "Pusher"


def test_only_requested_plugins_are_imported(packages):
    packages.add_plugin("my_plugins", "Good", "loader_good")
    packages.add_plugin("other_plugins", "Bad", "loader_lazy", "raise RuntimeError('imported')")

    assert PluginLoader().load("Good", ModelPlugin).__name__ == "Good"


def test_the_error_for_an_unknown_type_suggests_and_lists(packages):
    packages.add_plugin("a_plugins", "Laser", "loader_laser")
    packages.add_plugin("b_plugins", "DiffDrive", "loader_drive")

    for type in ("DifDrive", "b_plugins::DifDrive"):
        assert refusal(type) == (
            f'unknown plugin type "{type}" (did you mean "DiffDrive"?); there are: DiffDrive, Laser'
        )
    assert refusal("c_plugins::Laser").startswith('unknown plugin type "c_plugins::Laser"')


@pytest.mark.parametrize(
    ("type", "replacement"),
    [
        ("RandomGates", ""),
        ("RandomWandering", ", or use a Crowd whose pedestrians have several goals"),
        ("flatland_plugins::StaticLaser", ", or use a Laser with the map's layers"),
        ("VehicleMovement", ", or use a Pedestrian in a model without legs"),
    ],
)
def test_the_error_for_a_known_cpp_plugin_says_how_to_port_it(packages, type, replacement):
    expected = f"in Python: docs/coming_from_cpp.md says how to port it{replacement}"
    assert refusal(type).endswith(expected)


def test_without_any_plugin_the_error_asks_for_setup_bash(packages):
    assert refusal("Laser") == (
        'unknown plugin type "Laser"; there are: none; is the workspace\'s setup.bash sourced?'
    )


def test_a_name_in_two_packages_needs_its_package(packages):
    packages.add_plugin("a_plugins", "Laser", "loader_first")
    packages.add_plugin("b_plugins", "Laser", "loader_second")

    assert refusal("Laser") == (
        'the plugin type "Laser" is ambiguous: write a_plugins::Laser or b_plugins::Laser'
    )
    assert PluginLoader().load("b_plugins::Laser", ModelPlugin).__module__ == "loader_second"


@pytest.mark.parametrize("copy", ["a_copy", "z_copy"])
def test_a_copy_of_the_example_package_hides_the_original(packages, copy):
    packages.add_plugin("flatland_example_plugins", "Simple", "loader_example")
    packages.add_plugin(copy, "Simple", f"loader_{copy}")
    loader = PluginLoader()

    assert loader.load("Simple", ModelPlugin).__module__ == f"loader_{copy}"
    original = loader.load("flatland_example_plugins::Simple", ModelPlugin)
    assert original.__module__ == "loader_example"


@pytest.mark.parametrize("name", ["flatland_example_plugins", "my_plugins"])
def test_the_first_package_of_a_name_on_the_path_counts(packages, name, tmp_path, monkeypatch):
    packages.add_plugin(name, "Simple", "loader_underlay")
    overlay = Packages(tmp_path / "z_overlay")
    overlay.folder.mkdir()
    overlay.add_plugin(name, "Simple", "loader_overlay")
    (tmp_path / "z_overlay" / "loader_overlay.py").rename(tmp_path / "loader_overlay.py")
    path = f"{overlay.folder}:{packages.folder / name}"
    monkeypatch.setenv("ROS_PACKAGE_PATH", path)

    assert PluginLoader().load("Simple", ModelPlugin).__module__ == "loader_overlay"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import nothing_of_this_name", "No module named 'nothing_of_this_name'"),
        ("1 / 0", "division by zero"),
        ("class", "invalid syntax"),
    ],
)
def test_a_failing_import_names_the_plugin_and_its_module(packages, text, reason):
    packages.add_plugin("my_plugins", "Broken", "loader_broken", text)

    assert refusal("Broken").startswith(
        f'the plugin "Broken" of the package my_plugins cannot be imported: loader_broken: {reason}'
    )


def test_a_class_that_is_not_in_its_module_is_named(packages):
    packages.add_plugin("my_plugins", "Ghost", "loader_ghost", "")

    assert refusal("Ghost") == 'loader_ghost has no class "Ghost", though its package declares it'


@pytest.mark.parametrize("text", ["class {name}: pass", "def {name}(): pass", MODULE])
def test_a_class_that_is_not_of_the_required_kind_is_refused(packages, text):
    packages.add_plugin("my_plugins", "Thing", "loader_thing", text)

    assert refusal("Thing", WorldPlugin) == '"Thing" is not a WorldPlugin: loader_thing.Thing'


@pytest.mark.parametrize(
    ("xml", "word"),
    [
        ("<library><class", "line 1"),
        ("", "no element found"),
        ('<library><class type="Laser"/></library>', "module.Class"),
        (None, "No such file"),
    ],
)
def test_a_faulty_declaration_elsewhere_is_logged_and_skipped(packages, caplog, xml, word):
    packages.add("their_plugins", xml or "")
    if xml is None:
        (packages.folder / "their_plugins" / "plugins.xml").unlink()
    packages.add_plugin("your_plugins", "Good", "loader_beside")

    assert PluginLoader().load("Good", ModelPlugin).__name__ == "Good"

    [message] = warnings(caplog)
    assert "their_plugins" in message
    assert word in message


CPP_LIBRARY = """
<library path="lib/libtheir_plugins_lib">
  <class type="{namespace}::Pusher" base_class_type="flatland_server::ModelPlugin"/>
  <class name="their_plugins/Named" type="{namespace}::Named"
         base_class_type="flatland_server::WorldPlugin"/>
  <class type="{namespace}::Laser" base_class_type="flatland_server::ModelPlugin"/>
</library>
"""


@pytest.mark.parametrize("namespace", ["their_plugins", "flatland_plugins"])
@pytest.mark.parametrize("name", ["Pusher", "Named"])
def test_the_error_for_a_cpp_plugin_names_the_guide_to_porting(packages, caplog, namespace, name):
    packages.add("their_plugins", CPP_LIBRARY.format(namespace=namespace))

    for type in (name, f"{namespace}::{name}", f"their_plugins::{name}"):
        assert refusal(type) == (
            f'"{type}" is a C++ plugin of the package their_plugins ({namespace}::{name}); '
            "this Flatland runs plugins written in Python: "
            "docs/coming_from_cpp.md says how to port it"
        )
    assert warnings(caplog) == []


def test_a_package_of_cpp_plugins_does_not_disturb_others(packages, caplog):
    packages.add("their_plugins", CPP_LIBRARY.format(namespace="flatland_plugins"))
    packages.add_plugin("your_plugins", "Laser", "loader_your_laser")

    assert PluginLoader().load("Laser", ModelPlugin).__module__ == "loader_your_laser"
    assert "there are: Laser" in refusal("Lazer")
    assert "Pusher" not in refusal("Puscher")
    assert warnings(caplog) == []


def test_a_plugin_that_was_ported_hides_the_cpp_class(packages):
    both = CPP_LIBRARY.format(namespace="flatland_plugins").replace(
        "</library>", '<class name="Pusher" type="loader_ported.Pusher"/></library>'
    )
    packages.add("their_plugins", both, loader_ported=MODULE.format(name="Pusher"))

    for type in ("Pusher", "their_plugins::Pusher"):
        assert PluginLoader().load(type, ModelPlugin).__module__ == "loader_ported"


@pytest.mark.parametrize(
    "package_xml",
    [
        "<package><name>their_plugins</name><flatland_server",
        "<package><!-- <flatland_server --></package>",
    ],
)
def test_a_faulty_manifest_elsewhere_hides_no_plugins(packages, package_xml):
    packages.add("their_plugins", "", package_xml=package_xml)
    packages.add_plugin("your_plugins", "Good", "loader_manifest")

    assert PluginLoader().load("Good", ModelPlugin).__name__ == "Good"


def test_a_loaded_plugin_takes_no_memory_when_it_is_loaded_again(packages):
    packages.add_plugin("loader_pkg", "Loaded", "loader_again")
    loader = PluginLoader()
    loader.load("Loaded", ModelPlugin)
    tracemalloc.start()
    try:
        for _ in range(200):
            loader.load("Loaded", ModelPlugin)
        here = tracemalloc.Filter(True, plugin_loader.__file__)
        found = tracemalloc.take_snapshot().filter_traces([here]).statistics("filename")
    finally:
        tracemalloc.stop()
    assert sum(each.count for each in found) < 20

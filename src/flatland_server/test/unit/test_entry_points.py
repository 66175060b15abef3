"""Plugins are found by the entry points of Python packages, besides ROS packages."""

import logging
import sys
from pathlib import Path

import pytest

from flatland_server.exceptions import PluginError
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginLoader, discover

MODULE = """
from flatland_server import ModelPlugin
class {name}(ModelPlugin):
    pass
"""


class PythonPackages:
    """Installed packages in a folder on sys.path, in an environment without ROS packages."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def add(self, package: str, *entry_points: str, distribution: str = "") -> None:
        """Installs a package; its modules and classes are named as its entry points say."""
        for line in entry_points:
            module, _, name = line.partition("=")[2].strip().partition(":")
            if not name.isidentifier():  # a faulty one
                continue
            file = self.folder.joinpath(*module.split(".")).with_suffix(".py")
            file.parent.mkdir(exist_ok=True)
            file.write_text(MODULE.format(name=name))
        distribution = distribution or package
        info = self.folder / f"{distribution}-1.0.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\n")
        lines = "\n".join(entry_points)
        (info / "entry_points.txt").write_text(
            f"[console_scripts]\nf = f:f\n\n[flatland_server.plugins]\n{lines}\n"
        )

    def export(self, package: str, name: str, class_path: str) -> None:
        """Makes it a ROS package too."""
        folder = self.folder / "ros" / package
        folder.mkdir(parents=True)
        export = '<export><flatland_server plugin="${prefix}/plugins.xml"/></export>'
        (folder / "package.xml").write_text(f"<package><name>{package}</name>{export}</package>")
        (folder / "plugins.xml").write_text(
            f'<library><class name="{name}" type="{class_path}"/></library>'
        )


@pytest.fixture
def packages(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    monkeypatch.syspath_prepend(str(tmp_path))
    yield PythonPackages(tmp_path)
    for name in [name for name in sys.modules if name.startswith("loader_")]:
        del sys.modules[name]


def module_of(type: str) -> str:
    return PluginLoader().load(type, ModelPlugin).__module__


@pytest.mark.parametrize(
    ("type", "name"),
    [
        *((type, "Pusher") for type in ("Pusher", "loader_mine::Pusher")),
        *((type, "space::Pusher") for type in ("Pusher", "loader_mine::Pusher", "space::Pusher")),
    ],
)
def test_a_plugin_is_found_with_and_without_its_package_or_namespace(packages, type, name):
    packages.add("loader_mine", f"{name} = loader_mine.push:Pusher", distribution="my-robots")

    assert module_of(type) == "loader_mine.push"


def test_a_package_that_is_installed_later_is_found(packages):
    with pytest.raises(PluginError, match="unknown plugin type"):
        module_of("Pusher")

    packages.add("loader_mine", "Pusher = loader_mine.push:Pusher")

    assert module_of("Pusher") == "loader_mine.push"


@pytest.mark.parametrize("ros_package", ["loader_mine", "of_another_name"])
def test_a_class_that_a_ros_package_exports_too_counts_once(packages, ros_package):
    packages.add("loader_mine", "Pusher = loader_mine.push:Pusher")
    packages.export(ros_package, "Pusher", "loader_mine.push.Pusher")

    for type in ("Pusher", f"{ros_package}::Pusher", "loader_mine::Pusher"):
        assert module_of(type) == "loader_mine.push"
    assert [d.package for d in discover()] == [ros_package]


def test_a_class_in_two_distributions_counts_once(packages):
    for distribution in ("a", "b"):
        packages.add("loader_mine", "Pusher = loader_mine.push:Pusher", distribution=distribution)

    assert module_of("Pusher") == "loader_mine.push"


def test_a_cpp_class_of_the_same_name_is_hidden(packages):
    packages.add("loader_mine", "Pusher = loader_mine.push:Pusher")
    packages.export("loader_mine", "Pusher", "loader_mine::Pusher")

    assert module_of("Pusher") == "loader_mine.push"


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("Pusher = loader_mine.push", 'expected module:Class, found "loader_mine.push"'),
        ("Pusher = loader_mine:A.B", 'expected module:Class, found "loader_mine:A.B"'),
        ("Pusher", "Pusher"),
    ],
)
def test_a_faulty_declaration_is_logged_and_left_out(packages, caplog, line, word):
    packages.add("loader_good", "Good = loader_good.good:Good")
    packages.add("loader_mine", line)

    assert module_of("Good") == "loader_good.good"
    [message] = [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]
    assert "loader_mine" in message
    assert word in message


def test_without_ros_and_plugins_the_error_asks_for_pip(packages, monkeypatch):
    monkeypatch.delenv("ROS_PACKAGE_PATH")

    with pytest.raises(PluginError) as error:
        module_of("Laser")

    assert str(error.value) == (
        'unknown plugin type "Laser"; there are: none; '
        "is flatland2d installed in this Python (pip install)?"
    )

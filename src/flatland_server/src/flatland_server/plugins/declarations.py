"""The plugins that packages declare: their names in YAML files, and their classes.

A ROS package declares its plugins in the way of pluginlib, by an XML file that its package.xml
exports, and makes its modules importable with catkin_python_setup():

    <export><flatland_server plugin="${prefix}/flatland_plugins.xml"/></export>

    <library>
      <class name="ConstVelocity" type="my_plugins.const_velocity.ConstVelocity"
             base_class_type="flatland_server.ModelPlugin">
        <description>Moves a body at a constant velocity</description>
      </class>
    </library>

A Python package that pip installs does so by entry points in its setup.cfg, setup.py or
pyproject.toml:

    [project.entry-points."flatland_server.plugins"]
    ConstVelocity = "my_plugins.const_velocity:ConstVelocity"

The name is that in YAML files, alone or as `my_plugins::ConstVelocity`. It may have a namespace, as
that of a C++ class: `my_namespace::ConstVelocity`, and files may write it with that. A package may
declare its plugins in both ways, with the same files under catkin and under pip: a class that is
found twice counts once.
"""

import logging
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterator, List, Set, Tuple, Type

from flatland_server.config.packages import ros_package_folders
from flatland_server.plugins.plugin import Plugin

logger = logging.getLogger(__name__)

GROUP = "flatland_server.plugins"
"""The group of the entry points."""

_CLASS = re.compile(r"(?P<module>\w+(\.\w+)*)\s*:\s*(?P<name>\w+)")
_SEPARATOR = re.compile(r"::|[./]")


@dataclass(frozen=True)
class PluginDeclaration:
    """A class that a package declares.

    Args:
        name: name of the type in YAML files.
        package: package that declares the plugin.
        class_path: the module and the class, such as `flatland_plugins.laser.Laser`.
        is_cpp: whether it is a C++ class, as plugins of the original Flatland are.
        namespace: before the name, as in the declaration `my_namespace::ConstVelocity`.
    """

    name: str
    package: str
    class_path: str
    is_cpp: bool = False
    namespace: str = ""

    @classmethod
    def of(cls, plugin: Type[Plugin]) -> "PluginDeclaration":
        """The declaration of a class that no package exports, under its own name.

        Args:
            plugin: class of the plugin.
        """
        module = plugin.__module__
        return cls(plugin.__name__, module.partition(".")[0], f"{module}.{plugin.__name__}")

    def answers_to(self, type: str) -> bool:
        """True if a type in a YAML file means this class.

        Args:
            type: with or without a package or a namespace, such as `Laser` or
                `flatland_plugins::Laser`.
        """
        package, _, name = type.rpartition("::")
        known = ("", self.package, self._namespace, self.namespace)
        return name == self.name and package in known

    @property
    def _namespace(self) -> str:
        """The namespace or top-level module of the class; not always named like its package.

        Packages of C++ plugins mostly use the namespace flatland_plugins.
        """
        if self.is_cpp:
            return self.class_path.rpartition("::")[0]
        return self.class_path.partition(".")[0]


def discover() -> List[PluginDeclaration]:
    """The plugins that packages declare, each once; a faulty declaration is logged."""
    declarations = exported_plugins()
    known = {key for d in declarations if not d.is_cpp for key in _identities(d)}
    return declarations + [d for d in entry_point_plugins() if known.isdisjoint(_identities(d))]


def _identities(declaration: PluginDeclaration) -> Set[Tuple[str, str]]:
    """The keys of a declaration; two with a key in common mean the same plugin."""
    name = declaration.name
    return {(name, declaration.package), (name, declaration.class_path)}


def exported_plugins() -> List[PluginDeclaration]:
    """The plugins that packages on ROS_PACKAGE_PATH export; a faulty declaration is logged."""
    from xml.etree.ElementTree import ParseError

    exports: Dict[str, List[Path]] = {}
    for folder in ros_package_folders(os.environ.get("ROS_PACKAGE_PATH", "")):
        name, files = _exported_files(folder)
        if files:
            exports.setdefault(name, files)  # the first on the path hides those of the same name
    declarations: List[PluginDeclaration] = []
    for package, files in sorted(exports.items()):
        for xml in files:
            try:
                declarations.extend(read_declarations(package, xml))
            except (OSError, ParseError, ValueError) as error:
                logger.warning("the plugins of the package %s are left out: %s", package, error)
    return declarations


def _exported_files(folder: Path) -> Tuple[str, List[Path]]:
    """A package's name, and the plugin files that it exports. Most packages export none."""
    from xml.etree import ElementTree  # takes 4 ms

    manifest = folder / "package.xml"
    try:
        text = manifest.read_text(encoding="utf-8")
        if "<flatland_server" not in text:
            return "", []
        root = ElementTree.fromstring(text)
    except (OSError, UnicodeDecodeError, ElementTree.ParseError) as error:
        logger.warning("%s is left out: %s", manifest, error)
        return "", []
    files = [export.get("plugin", "") for export in root.iterfind("export/flatland_server")]
    name = (root.findtext("name") or folder.name).strip()
    return name, [Path(file.replace("${prefix}", str(folder))) for file in files if file]


def read_declarations(package: str, xml: Path) -> List[PluginDeclaration]:
    """The plugins in an XML file.

    Raises:
        ElementTree.ParseError: it is not XML.
        ValueError: it names no class of a module.
        OSError: it cannot be read.
    """
    from xml.etree import ElementTree

    root = ElementTree.fromstring(xml.read_text(encoding="utf-8"))
    declarations = []
    for element in root.iter("class"):
        class_path = element.get("type", "")
        is_cpp = "::" in class_path
        if "." not in class_path and not is_cpp:
            raise ValueError(f'{xml}: expected type="module.Class", found "{class_path}"')
        *namespaces, name = _SEPARATOR.split(element.get("name", class_path))
        namespace = "::".join(namespaces)
        declarations.append(PluginDeclaration(name, package, class_path, is_cpp, namespace))
    return declarations


def entry_point_plugins() -> List[PluginDeclaration]:
    """The plugins of the packages on sys.path; a faulty declaration is logged."""
    from importlib import metadata  # takes 10 ms

    # Not metadata.entry_points(): it parses the entry points of all packages before Python 3.10.
    packages: Dict[str, List[PluginDeclaration]] = {}
    for distribution in metadata.distributions():
        text = distribution.read_text("entry_points.txt") or ""
        if f"[{GROUP}]" in text:
            name = distribution.metadata["Name"]
            packages.setdefault(name, list(_read_declarations(name, text)))  # the first on the path
    return [declaration for _, found in sorted(packages.items()) for declaration in found]


def _read_declarations(distribution: str, text: str) -> Iterator[PluginDeclaration]:
    """The plugins in the entry_points.txt of a package."""
    import configparser

    parser = configparser.ConfigParser(delimiters=("=",), interpolation=None)
    parser.optionxform = str  # type: ignore[assignment,method-assign]  # names keep their case
    try:
        parser.read_string(text)
    except configparser.Error as error:
        logger.warning("the plugins of the package %s are left out: %s", distribution, error)
        return
    for full_name, value in parser.items(GROUP):
        found = _CLASS.fullmatch(value.strip())
        if found:
            namespace, _, name = full_name.rpartition("::")
            package, path = found["module"].partition(".")[0], f"{found['module']}.{found['name']}"
            yield PluginDeclaration(name, package, path, namespace=namespace)
        else:
            logger.warning(
                'the plugin "%s" of the package %s is left out: expected module:Class, found "%s"',
                full_name,
                distribution,
                value,
            )

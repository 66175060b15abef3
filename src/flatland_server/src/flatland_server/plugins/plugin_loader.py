"""Finds plugins by their type, as pluginlib does.

A package declares its plugins in an XML file and exports it in its package.xml:

    <export><flatland_server plugin="${prefix}/flatland_plugins.xml"/></export>

    <library>
      <class name="ConstVelocity" type="my_plugins.const_velocity.ConstVelocity"
             base_class_type="flatland_server.ModelPlugin">
        <description>Moves a body at a constant velocity</description>
      </class>
    </library>

`type` is the importable Python class, `name` its name in YAML files, alone or as
`my_plugins::ConstVelocity`. The package makes its modules importable with catkin_python_setup().
A C++ class, whose `type` has `::`, cannot be loaded: only a file that names it gets an error.
A plugin of `EXAMPLE_PACKAGE`, which is there to be copied, is hidden by others of the same name.
"""

import importlib
import inspect
import logging
import os
import re
import warnings
import xml.etree.ElementTree as ElementTree
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import (
    Dict,
    Iterable,
    Iterator,
    List,
    Optional,
    Set,
    TextIO,
    Tuple,
    Type,
    TypeVar,
    Union,
)

from flatland_server._deprecated import FormerNameWarning
from flatland_server.exceptions import PluginError, shortened, suggestion
from flatland_server.plugins.plugin import Plugin

logger = logging.getLogger(__name__)

P = TypeVar("P", bound=Plugin)

EXAMPLE_PACKAGE = "flatland_example_plugins"
"""The package that users copy under another name: a copy hides the plugins of the original."""

_SEPARATOR = re.compile(r"::|[./]")
_IGNORED = {"CATKIN_IGNORE", "AMENT_IGNORE", "rospack_nosubdirs"}


@dataclass(frozen=True)
class PluginDeclaration:
    """A class that a package declares."""

    name: str
    package: str
    class_path: str
    is_cpp: bool = False
    """Whether it is a C++ class, as plugins of the original Flatland are."""

    @classmethod
    def of(cls, plugin: Type[Plugin]) -> "PluginDeclaration":
        """The declaration of a class that no package exports, under its own name."""
        module = plugin.__module__
        return cls(plugin.__name__, module.partition(".")[0], f"{module}.{plugin.__name__}")

    def answers_to(self, type: str) -> bool:
        """Whether the `type` in a YAML file means this class."""
        package, _, name = type.rpartition("::")
        # Packages of C++ plugins mostly use the namespace flatland_plugins.
        namespace = self.class_path.rpartition("::")[0]
        return name == self.name and package in ("", self.package, namespace)


class PluginLoader:
    """Imports plugins on demand.

    Args:
        declarations: the available plugins; by default those that packages on ROS_PACKAGE_PATH
            export, which are looked up when the first plugin is needed.
    """

    def __init__(self, declarations: Optional[Iterable[PluginDeclaration]] = None) -> None:
        self._declarations = None if declarations is None else list(declarations)

    def load(self, type: str, base: Type[P]) -> Type[P]:
        """The class that the `type` in a YAML file means.

        Raises:
            PluginError: there is no such plugin or more than one, it cannot be imported, or it is
                not derived from `base`.
        """
        if self._declarations is None:
            self._declarations = discover()
        answering = [d for d in self._declarations if d.answers_to(type)]
        found = [d for d in answering if not d.is_cpp]
        if answering and not found:
            raise PluginError(_cpp_error(type, answering[0]))
        if not found:
            names = sorted(d.name for d in self._declarations if not d.is_cpp)
            known = ", ".join(names) or "none; is the workspace's setup.bash sourced?"
            hint = suggestion(type.rpartition("::")[2], names)
            raise PluginError(f'unknown plugin type "{shortened(type)}"{hint}; there are: {known}')
        if len(found) > 1:
            found = [d for d in found if d.package != EXAMPLE_PACKAGE] or found
        if len(found) > 1:
            choices = " or ".join(f"{d.package}::{d.name}" for d in found)
            raise PluginError(f'the plugin type "{type}" is ambiguous: write {choices}')
        cls = _import(found[0])
        if not (inspect.isclass(cls) and issubclass(cls, base)):
            raise PluginError(f'"{type}" is not a {base.__name__}: {found[0].class_path}')
        return cls


def _cpp_error(type: str, declaration: PluginDeclaration) -> str:
    return (
        f'"{type}" is a C++ plugin of the package {declaration.package} '
        f"({declaration.class_path}); this Flatland runs plugins written in Python: "
        "docs/coming_from_cpp.md says how to port it"
    )


def _import(declaration: PluginDeclaration) -> object:
    module_name, _, class_name = declaration.class_path.rpartition(".")
    try:
        with _log_former_names(declaration.package):
            module = importlib.import_module(module_name)
    except Exception as error:
        raise PluginError(
            f'the plugin "{declaration.name}" of the package {declaration.package} cannot be '
            f"imported: {module_name}: {error}"
        ) from error
    if not hasattr(module, class_name):
        raise PluginError(f'{module_name} has no class "{class_name}", though its XML names it')
    return getattr(module, class_name)


@contextmanager
def _log_former_names(package: str) -> Iterator[None]:
    """Logs each line that uses a former name of `flatland_server`, while a plugin is imported.

    Python shows these warnings only for code in `__main__`, which plugins never are.
    """
    logged: Set[Tuple[str, int, str]] = set()

    def show(
        message: Union[Warning, str],
        category: Type[Warning],
        filename: str,
        lineno: int,
        file: Optional[TextIO] = None,
        line: Optional[str] = None,
    ) -> None:
        use = (filename, lineno, str(message))
        if not issubclass(category, FormerNameWarning):
            show_others(message, category, filename, lineno, file, line)
        elif use not in logged:
            logged.add(use)
            logger.warning("the plugin package %s should be updated: %s:%d: %s", package, *use)

    with warnings.catch_warnings():
        warnings.simplefilter("always", FormerNameWarning)
        show_others = warnings.showwarning
        warnings.showwarning = show
        yield


def discover() -> List[PluginDeclaration]:
    """The plugins that packages on ROS_PACKAGE_PATH export; a faulty declaration is logged."""
    exports: Dict[str, List[Path]] = {}
    for folder in _package_folders():
        name, files = _exported_files(folder)
        if files:
            exports.setdefault(name, files)  # the first on the path hides those of the same name
    declarations: List[PluginDeclaration] = []
    for package, files in sorted(exports.items()):
        for xml in files:
            try:
                declarations.extend(_read_declarations(package, xml))
            except (OSError, ElementTree.ParseError, ValueError) as error:
                logger.warning("the plugins of the package %s are left out: %s", package, error)
    return declarations


def _package_folders() -> Iterator[Path]:
    """The folders with a package.xml. Unlike rospkg's list, they do not depend on its contents."""
    seen: Set[str] = set()
    for path in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        for folder, subfolders, files in os.walk(path, followlinks=True):
            real = os.path.realpath(folder)
            if real in seen or _IGNORED.intersection(files):
                subfolders.clear()
            elif "package.xml" in files:
                subfolders.clear()
                yield Path(folder)
            else:  # as rospack, which does not look into .git and the like either
                subfolders[:] = [name for name in subfolders if not name.startswith(".")]
            seen.add(real)


def _exported_files(folder: Path) -> Tuple[str, List[Path]]:
    """A package's name, and the plugin files that it exports. Most packages export none."""
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


def _read_declarations(package: str, xml: Path) -> List[PluginDeclaration]:
    root = ElementTree.fromstring(xml.read_text(encoding="utf-8"))
    declarations = []
    for element in root.iter("class"):
        class_path = element.get("type", "")
        is_cpp = "::" in class_path
        if "." not in class_path and not is_cpp:
            raise ValueError(f'{xml}: expected type="module.Class", found "{class_path}"')
        name = _SEPARATOR.split(element.get("name", class_path))[-1]
        declarations.append(PluginDeclaration(name, package, class_path, is_cpp))
    return declarations

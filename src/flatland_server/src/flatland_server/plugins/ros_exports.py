"""The plugins that ROS packages export, in the way of pluginlib.

A package declares its plugins in an XML file and exports it in its package.xml:

    <export><flatland_server plugin="${prefix}/flatland_plugins.xml"/></export>

    <library>
      <class name="ConstVelocity" type="my_plugins.const_velocity.ConstVelocity"
             base_class_type="flatland_server.ModelPlugin">
        <description>Moves a body at a constant velocity</description>
      </class>
    </library>

`type` is the importable Python class, `name` its name in YAML files. The package makes its modules
importable with catkin_python_setup().
"""

import logging
import os
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Dict, List, Tuple

from flatland_server.config.packages import ros_package_folders
from flatland_server.plugins.plugin_declaration import PluginDeclaration

logger = logging.getLogger(__name__)

_SEPARATOR = re.compile(r"::|[./]")


def exported_plugins() -> List[PluginDeclaration]:
    """The plugins that packages on ROS_PACKAGE_PATH export; a faulty declaration is logged."""
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
            except (OSError, ElementTree.ParseError, ValueError) as error:
                logger.warning("the plugins of the package %s are left out: %s", package, error)
    return declarations


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


def read_declarations(package: str, xml: Path) -> List[PluginDeclaration]:
    """The plugins in an XML file.

    Raises:
        ElementTree.ParseError: it is not XML.
        ValueError: it names no class of a module.
        OSError: it cannot be read.
    """
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

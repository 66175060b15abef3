"""The plugins that installed Python packages declare by entry points.

A package names its plugins in its setup.cfg, setup.py or pyproject.toml:

    [project.entry-points."flatland_server.plugins"]
    ConstVelocity = "my_plugins.const_velocity:ConstVelocity"

The name is that in YAML files, alone or as `my_plugins::ConstVelocity`.
"""

import configparser
import logging
import os
import re
import sys
from functools import lru_cache
from importlib import metadata
from typing import Dict, Iterator, List, Tuple

from flatland_server.plugins.plugin_declaration import PluginDeclaration

logger = logging.getLogger(__name__)

GROUP = "flatland_server.plugins"

_CLASS = re.compile(r"(?P<module>\w+(\.\w+)*)\s*:\s*(?P<name>\w+)")


def entry_point_plugins() -> List[PluginDeclaration]:
    """The plugins of the packages on sys.path; a faulty declaration is logged.

    They are looked up again only if sys.path or the contents of a folder on it have changed.
    """
    return list(_entry_point_plugins(tuple((path, _revision(path)) for path in sys.path)))


def _revision(path: str) -> int:
    """A value that changes when a package is installed into a folder, or removed."""
    try:
        return os.stat(path or ".").st_mtime_ns
    except OSError:
        return 0


@lru_cache(maxsize=1)
def _entry_point_plugins(_: Tuple[Tuple[str, int], ...]) -> Tuple[PluginDeclaration, ...]:
    # Not metadata.entry_points(): it parses the entry points of all packages before Python 3.10.
    packages: Dict[str, List[PluginDeclaration]] = {}
    for distribution in metadata.distributions():
        text = distribution.read_text("entry_points.txt") or ""
        if f"[{GROUP}]" in text:
            name = distribution.metadata["Name"]
            packages.setdefault(name, list(_read_declarations(name, text)))  # the first on the path
    return tuple(declaration for _, found in sorted(packages.items()) for declaration in found)


def _read_declarations(distribution: str, text: str) -> Iterator[PluginDeclaration]:
    """The plugins in the entry_points.txt of a package."""
    parser = configparser.ConfigParser(delimiters=("=",), interpolation=None)
    parser.optionxform = str  # type: ignore[assignment,method-assign]  # names keep their case
    try:
        parser.read_string(text)
    except configparser.Error as error:
        logger.warning("the plugins of the package %s are left out: %s", distribution, error)
        return
    for name, value in parser.items(GROUP):
        found = _CLASS.fullmatch(value.strip())
        if found:
            module = found.group("module")
            class_path = f"{module}.{found.group('name')}"
            yield PluginDeclaration(name, module.partition(".")[0], class_path)
        else:
            logger.warning(
                'the plugin "%s" of the package %s is left out: expected module:Class, found "%s"',
                name,
                distribution,
                value,
            )

"""The folders of packages: of ROS packages on ROS_PACKAGE_PATH, and of installed Python packages.

A package of robots has the same files under catkin and under pip, in different places.
`package_folders("my_robots")` are the folders that may contain its `worlds/`:

| installed by | folder |
| --- | --- |
| catkin | the ROS package: its source, or `<prefix>/share/my_robots` |
| pip, files of the Python package (`package_data`) | `site-packages/my_robots` |
| pip, files beside it (`data_files`) | `<prefix>/share/my_robots` |
| pip --editable | the source, where its package.xml is |
"""

import importlib.util
import os
import re
import sys
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Dict, Iterable, Iterator, List, Mapping, Set

_IGNORED = {"CATKIN_IGNORE", "AMENT_IGNORE", "rospack_nosubdirs"}
_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")

_SOURCE_DEPTH = 2  # a package's sources are in <package>/<name> or in <package>/src/<name>
_PREFIX_DEPTH = 4  # <prefix>/lib/python3.X/site-packages/<name>


def package_folders(name: str) -> List[Path]:
    """The folders that have a package's files, in the order in which a file is looked up.

    A ROS package of this name hides the Python package.

    Returns:
        An empty list if there is no such package.
    """
    ros_package = ros_packages().get(name)
    if ros_package:
        return [ros_package]
    return folders_beside(name, python_package_folders(name, with_namespaces=False))


def folders_beside(name: str, locations: Iterable[Path]) -> List[Path]:
    """The folders that have the files of a Python package."""
    found: Dict[Path, None] = {}
    for location in locations:
        found[location] = None
        for parent in islice(location.parents, _SOURCE_DEPTH):
            if ros_package_name(parent) == name:
                found[parent] = None
        for parent in islice(location.parents, _PREFIX_DEPTH):
            if (parent / "share" / name).is_dir():
                found[parent / "share" / name] = None
    return list(found)


def ros_packages() -> Mapping[str, Path]:
    """The folders of the ROS packages by their names; looked up once for a ROS_PACKAGE_PATH."""
    return _ros_packages(os.environ.get("ROS_PACKAGE_PATH", ""))


@lru_cache(maxsize=1)
def _ros_packages(search_path: str) -> Mapping[str, Path]:
    packages: Dict[str, Path] = {}
    for folder in ros_package_folders(search_path):
        packages.setdefault(ros_package_name(folder), folder)  # the first on the path counts
    return packages


def ros_package_folders(search_path: str) -> Iterator[Path]:
    """The folders with a package.xml. Unlike rospkg's list, they do not depend on its contents."""
    seen: Set[str] = set()
    for path in filter(None, search_path.split(os.pathsep)):
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


def ros_package_name(folder: Path) -> str:
    """The name in a folder's package.xml; empty if it has none."""
    try:
        name = _NAME.search((folder / "package.xml").read_bytes())
    except OSError:
        return ""
    return name.group(1).decode("utf-8", "replace") if name else folder.name


def python_package_folders(name: str, *, with_namespaces: bool) -> List[Path]:
    """The folders of a top-level package's modules; it is not imported for that.

    Args:
        name: the package's name.
        with_namespaces: whether packages without an `__init__` count: any folder on sys.path.
    """
    if not name.isidentifier():
        return []
    module = sys.modules.get(name)
    if module is not None:  # catkin's devel space adds to the path of a package that is imported
        return [Path(location) for location in getattr(module, "__path__", ())]
    try:
        spec = importlib.util.find_spec(name)
    except ImportError:
        return []
    if spec is None or not (spec.origin or with_namespaces):
        return []
    return [Path(location) for location in spec.submodule_search_locations or ()]

"""What users write for a file: a path, a `package://` URI, or a name in one of several folders."""

import os
from functools import lru_cache
from pathlib import Path
from typing import Any, Sequence, Union

from flatland_server.config.input_files import is_file
from flatland_server.exceptions import FlatlandError, listed, shortened, suggestion

_SCHEME = "package://"


def to_path(name: Union[str, Path]) -> Path:
    """The path that a name means: itself, or for `package://name/path`, one in a ROS package.

    Raises:
        FlatlandError: there is no such package, or no rospkg to find it.
    """
    text = os.fspath(name)
    if not text.startswith(_SCHEME):
        return Path(text)
    package, _, inner = text[len(_SCHEME) :].partition("/")
    if not package or not inner:
        raise FlatlandError(f'expected package://name/path, found "{shortened(text)}"')
    return _package_folder(package) / inner


def find_file(name: Union[str, Path], folders: Sequence[Path]) -> Path:
    """The first regular file of this name: absolute or in a package, or else in one of the folders.

    Args:
        name: a path or a `package://` URI.
        folders: where a relative path is looked up, the preferred one first; at least one.

    Returns:
        The path in the first folder, if no folder has the file.

    Raises:
        FlatlandError: as for `to_path`.
    """
    path = to_path(name)
    candidates = [folder / path for folder in folders]
    return next(filter(is_file, candidates), candidates[0])


def is_bare(name: Union[str, Path]) -> bool:
    """Whether a name is looked up in the folders of models: relative, without "./" or "../"."""
    text = os.fspath(name)
    return not text.startswith(("/", "./", "../", _SCHEME)) and text not in ("", ".", "..")


def nor_in(folders: Sequence[Path]) -> str:
    """For the error of a file that is missing: the other folders where it was looked up, if any."""
    return f", nor in {listed([str(folder) for folder in folders])}" if folders else ""


def _package_folder(package: str) -> Path:
    try:
        import rospkg
    except ImportError:
        raise FlatlandError(f"{_SCHEME} needs rospkg, a Python package of ROS") from None
    packages = _packages(os.environ.get("ROS_PACKAGE_PATH", ""))
    try:
        return Path(packages.get_path(package))
    except rospkg.ResourceNotFound:
        hint = suggestion(package, packages.list())
        message = f'no ROS package is named "{shortened(package)}"{hint}'
        raise FlatlandError(f"{message}; is the workspace's setup.bash sourced?") from None


@lru_cache(maxsize=1)
def _packages(search_path: str) -> Any:
    """The packages on ROS_PACKAGE_PATH, which are looked up once."""
    import rospkg

    return rospkg.RosPack(search_path.split(os.pathsep))

"""File names as users write them: paths, `package://` URIs, and names in one of several folders."""

import os
import pkgutil
from pathlib import Path
from typing import Sequence, Union

from flatland_server.config.input_files import is_file
from flatland_server.config.packages import package_folders, ros_packages
from flatland_server.exceptions import FlatlandError, listed, shortened, suggestion

_SCHEME = "package://"
_HOME = "~/"
_LONGEST = 4096  # characters of a path; Linux refuses longer ones, pathlib takes minutes for some


def to_path(name: Union[str, Path]) -> Path:
    """The path of a name: the name itself, or the file of a `package://name/path`.

    A path may begin with `~/`, the home folder: no shell expands it in `world_path:=~/world.yaml`,
    in a request of a service, or in a file. A package is a ROS package on ROS_PACKAGE_PATH, or else
    an installed Python package. Of the folders of a Python package (see `config.packages`), the
    first one with the path is used.

    Raises:
        FlatlandError: there is no such package, or the name is longer than any path.
    """
    text = os.fspath(name)
    if len(text) > _LONGEST:
        raise FlatlandError(
            f'expected a path of at most {_LONGEST} characters, found "{shortened(text)}"'
        )
    if text.startswith("$(find "):  # as in launch files
        raise FlatlandError(f'expected package://name/path, found "{shortened(text)}"')
    if not text.startswith(_SCHEME):
        return Path(os.path.expanduser(text) if text.startswith(_HOME) else text)
    package, _, inner = text[len(_SCHEME) :].partition("/")
    if not package or not inner:
        raise FlatlandError(f'expected package://name/path, found "{shortened(text)}"')
    candidates = [folder / inner for folder in package_folders(package)]
    if not candidates:
        raise _unknown_package(package)
    return next(filter(os.path.exists, candidates), candidates[0])


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
    """True if a name is looked up in the folders of models: relative, without "./" or "../"."""
    text = os.fspath(name)
    return not text.startswith(("/", "./", "../", _HOME, _SCHEME)) and text not in ("", ".", "..")


def nor_in(folders: Sequence[Path]) -> str:
    """The part of a missing file's error that lists the other folders searched; may be empty."""
    return f", nor in {listed([str(folder) for folder in folders])}" if folders else ""


def _unknown_package(name: str) -> FlatlandError:
    """The error for an unknown package, worded for users of ROS or of pip."""
    if "ROS_PACKAGE_PATH" in os.environ:
        known = list(ros_packages())
        kind, question = "ROS", "is the workspace's setup.bash sourced?"
    else:
        known = [module.name for module in pkgutil.iter_modules() if module.ispkg]
        kind, question = "Python", "is it installed (pip install)?"
    near = suggestion(name, known)
    return FlatlandError(f'no {kind} package is named "{shortened(name)}"{near}; {question}')

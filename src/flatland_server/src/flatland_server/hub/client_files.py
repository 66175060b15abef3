"""The files that clients of services may name, and what they are told about them.

A client may be anywhere in the ROS network. It gets no content of files that are not Flatland's.
If the server has a folder of states, it names files only in the folders that its owner has named.
"""

import os
import re
from pathlib import Path
from typing import Any, Optional, Union

import yaml

from flatland_server.config.composed_files import compose_file
from flatland_server.config.file_names import to_path
from flatland_server.config.packages import package_folders
from flatland_server.config.worlds import is_shipped
from flatland_server.config.yaml_reader import is_text
from flatland_server.exceptions import (
    FlatlandError,
    ModelError,
    Problem,
    StateError,
    YamlError,
    shortened,
)
from flatland_server.simulation.world import World

_LONGEST = 500  # characters of a line for a client
_PACKAGE = re.compile("package://([^/]+)/")


class ClientFiles:
    """Finds the files that clients name.

    Args:
        world: the simulated world, which has folders of models.
        state_folder: the server's `~state_folder`; None lets clients name any file.
    """

    def __init__(self, world: World, state_folder: Optional[Path]) -> None:
        self._world = world
        self._state_folder = state_folder

    def state(self, name: str) -> Path:
        """The path of a state file.

        Raises:
            FlatlandError: the name is relative and there is no folder of states, or it leads out of
                that folder.
        """
        path = to_path(name)
        if self._state_folder is None:
            if path.is_absolute():
                return path
            raise StateError(
                "expected an absolute path (the server has no ~state_folder), found "
                f'"{shortened(name)}"'
            )
        path = self._state_folder / path
        self._require_within(path, self._state_folder)
        return path

    def world_file(self, name: str) -> Path:
        """The path of a world file.

        Raises:
            FlatlandError: the name is relative, or leads out of the folders for clients.
        """
        path = to_path(name)
        if not path.is_absolute():
            raise FlatlandError(f'expected an absolute path, found "{shortened(name)}"')
        return self._readable(path, name)

    def written_world(self, name: str) -> Path:
        """The path of a world file that is to be written.

        Args:
            name: absolute; empty for the world's own file.

        Raises:
            FlatlandError: the world has no file, or no name is given and it is one of Flatland's
                own; the name is relative or leads out of the folder of
                states, or something is there that is no world file, such as a link to one.
        """
        own = self._world.config.path and self._world.config.path.absolute()
        path = to_path(name) if name else own
        if path is None:
            raise FlatlandError("the world was made without a file; expected the path of a new one")
        if not name and is_shipped(path):
            raise FlatlandError("the world is one of Flatland's own; save a copy of it")
        if not path.is_absolute():
            raise FlatlandError(f'expected an absolute path, found "{shortened(name)}"')
        if self._state_folder is not None:
            self._require_within(path, self._state_folder)
        if path.suffix not in (".yaml", ".yml"):
            raise FlatlandError(f"expected a file *.yaml, found {path}")
        if path.is_symlink():
            raise FlatlandError(f"{path}: expected a new file or a world, found a link")
        if os.path.lexists(path) and path != own and not self._is_world(path):
            raise FlatlandError(f"{path}: expected a new file or a world, found something else")
        return path

    def _is_world(self, path: Path) -> bool:
        try:
            self._world.read_config(path)
        except FlatlandError:
            return False
        return True

    def model_file(self, name: str) -> Path:
        """The path of a model file; a relative one begins in the world's folder.

        Raises:
            FlatlandError: there is no such file, or it is not in the folders for clients.
        """
        if "\n" in name:
            raise ModelError(
                "expected the path of a model file, found a text: /spawn_model_from_string takes "
                "one"
            )
        config = self._world.config
        return self._readable(config.find_model(name, config.model_folders[0]), name)

    def _readable(self, path: Path, name: str) -> Path:
        if self._state_folder is not None:
            package = _PACKAGE.match(name)
            packages = package_folders(package[1]) if package else ()
            self._require_within(
                path, self._state_folder, *self._world.config.model_folders, *packages
            )
        return path

    def _require_within(self, path: Path, *folders: Path) -> None:
        real = path.resolve()
        if not any(folder.resolve() in real.parents for folder in folders):
            raise FlatlandError(
                "expected a file in the folders that the server's ~state_folder leaves to clients, "
                f"found {path}"
            )


class EntryError(FlatlandError):
    """An error of one entry of a request's list.

    Args:
        entry: name of the entry in the request.
        error: the error of that entry.
    """

    def __init__(self, entry: str, error: FlatlandError) -> None:
        super().__init__(f"{entry}: {error}")
        self.entry = entry
        self.error = error


def told(error: Union[FlatlandError, ValueError]) -> str:
    """An error for a client: short lines, and nothing that is written in files of other kinds."""
    if isinstance(error, EntryError):
        kind, _, text = told(error.error).partition(": ")
        return f"{kind}: {error.entry}: {text}"
    lines = error.lines(_line_of) if isinstance(error, YamlError) else str(error).splitlines()
    text = "\n".join(shortened(line, _LONGEST) for line in lines)
    return f"{type(error).__name__}: {text}"


def _line_of(problem: Problem) -> str:
    if is_text(problem.file) or _is_of_flatland(problem.file):
        return str(problem)
    message = problem.message.partition(", found ")[0]
    if not message.startswith("the required key"):
        message = re.sub('"[^"]*"', '"..."', message)
    message = message.partition("is not valid YAML")[1] or message
    return str(Problem(problem.file, message, problem.line))


def _is_of_flatland(path: Path) -> bool:
    """True if a file is evidently a world or a model: it has the lists that these must have."""
    try:
        root: Any = compose_file(path).documents[0]
    except FlatlandError:
        return False
    pairs = root.value if isinstance(root, yaml.MappingNode) else []
    values = {str(key.value): value for key, value in pairs}
    is_world = "properties" in values and _is_list(values.get("layers"))
    return is_world or _is_list(values.get("bodies"))


def _is_list(node: Any) -> bool:
    """True for a list, also one that is in another file."""
    return isinstance(node, yaml.SequenceNode) or (
        isinstance(node, yaml.ScalarNode) and node.value.startswith("$include ")
    )

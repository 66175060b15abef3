"""The service that saves a world's changed models into its file: /save_world."""

import os
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, List, Tuple

from flatland_server.config.input_files import replacing
from flatland_server.config.world_file_text import NewEntry, WorldFileText, plain
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import FlatlandError, YamlError, counted
from flatland_server.serving.client_edits import Changes, ClientEdits
from flatland_server.serving.client_files import ClientFiles
from flatland_server.serving.service_host import ServiceHost
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world_config import ModelEntry, WorldConfig


class WorldSaving:
    """Offers /save_world.

    The file is read as it is now, changed, read again, and compared with what it should be, before
    it replaces the former one. The saved world is the one to which a reset leads from then on.

    Args:
        manager: the simulation.
        host: offers the service.
        files: knows the files that clients may write.
        edits: what clients have changed.
    """

    def __init__(
        self, manager: SimulationManager, host: ServiceHost, files: ClientFiles, edits: ClientEdits
    ) -> None:
        self._manager = manager
        self._host = host
        self._files = files
        self._edits = edits
        host.offer("save_world", "flatland_msgs/SaveWorld", self._save_world)

    def _save_world(self, request: Any) -> Dict[str, Any]:
        path = self._files.written_world(request.path)
        config, changes = self._host.call(lambda: (self._manager.world.config, self._edits.changes))
        if config.path is None:
            raise FlatlandError("the world was made without a file")
        with_file = [entry for entry in changes.added if entry.model.content is None]
        unsaved = [entry.name for entry in changes.added if entry not in with_file]
        saved = changes._replace(added=with_file)
        content, expected = self._new_content(config, saved, path)
        self._write(path, content, expected, config)
        self._host.call(lambda: self._take_over(config, saved, path))
        self._host.world_is_open(str(path))
        message = f"{counted(saved.number, 'changed model')} saved in {path}"
        if unsaved:
            message += f"; without a file, and not saved: {', '.join(unsaved)}"
        return {"message": message}

    def _new_content(
        self, config: WorldConfig, changes: Changes, path: Path
    ) -> Tuple[bytes, Dict[str, Any]]:
        """The new text of a world's file, and the value that it should have."""
        assert config.path is not None
        with self._preprocessor() as preprocessor:
            root = preprocessor.read(config.path)
        text = WorldFileText(config.path, root)
        folders = (path.parent, *config.model_folders[1:])
        added = [
            NewEntry(entry.name, entry.namespace, _name_of(entry, folders), entry.pose)
            for entry in changes.added
        ]
        former = {entry.name: entry.pose for entry in config.models}
        text.change_models(
            {name: (former[name], pose) for name, pose in changes.poses.items()},
            changes.deleted,
            added,
        )
        if path.parent != config.path.resolve().parent:
            text.name_files_from(config.path.parent)
        return text.content, _changed(plain(root), changes, added)

    def _write(
        self, path: Path, content: bytes, expected: Dict[str, Any], config: WorldConfig
    ) -> None:
        """Writes a world file, if it can be read and has the value that it should have."""
        try:
            with replacing(path) as partial:
                with partial.open("xb") as file:
                    file.write(content)
                if path.exists():
                    partial.chmod(path.stat().st_mode)
                if not self._is_as(partial, expected, config):
                    raise FlatlandError(
                        f"{config.path}: the models are written in a way that they cannot be "
                        "changed without changing others: edit it by hand"
                    )
                self._files.written_world(str(path))  # still
        except OSError as error:
            raise FlatlandError(f"cannot write {path}: {error.strerror}") from None

    def _is_as(self, path: Path, expected: Dict[str, Any], config: WorldConfig) -> bool:
        """True if a file can be read, and has a value."""
        assert config.path is not None
        is_moved = path.parent != config.path.resolve().parent
        try:
            with self._preprocessor() as preprocessor:
                if is_moved:
                    config.read_again(path, preprocessor)
            with self._preprocessor() as preprocessor:
                found = plain(preprocessor.read(path))
        except YamlError:
            return False
        return _comparable(found, is_moved) == _comparable(expected, is_moved)

    def _take_over(self, config: WorldConfig, changes: Changes, path: Path) -> None:
        """Makes the saved models those of the world's file."""
        manager = self._manager
        if manager.world.config is not config:
            return  # another world was opened meanwhile
        entries = [
            replace(entry, pose=changes.poses.get(entry.name, entry.pose))
            for entry in config.models
            if entry.name not in changes.deleted
        ]
        manager.world.contents.config = replace(
            config,
            models=(*entries, *changes.added),
            model_folders=(path.parent, *config.model_folders[1:]),
            path=path,
            with_seed=None,  # it has the saved values, whatever the seed
        )
        self._edits.clear()
        if manager.history is not None:
            manager.history.restart()  # its states are of the former file

    def _preprocessor(self) -> "closing[YamlPreprocessor]":
        return closing(YamlPreprocessor(self._manager.transport.get_param))


def _name_of(entry: ModelEntry, folders: Tuple[Path, ...]) -> str:
    """The name of a model's file in a world file: as short as it is found there."""
    path = Path(os.path.abspath(entry.model.path))
    for folder in folders:
        if folder.resolve() in path.parents:
            return path.relative_to(folder.resolve()).as_posix()
    return str(path)


def _changed(content: Dict[str, Any], changes: Changes, added: List[NewEntry]) -> Dict[str, Any]:
    """The value of a world's file with changed models."""
    models = []
    for model in content.get("models") or []:
        name = model.get("name")
        is_enabled = model.get("enabled", True) is not False
        if is_enabled and name in changes.deleted:
            continue
        if is_enabled and name in changes.poses:
            model = {**model, "pose": list(changes.poses[name])}
        models.append(model)
    for entry in added:
        new: Dict[str, Any] = {"name": entry.name, "model": entry.model, "pose": list(entry.pose)}
        if entry.namespace:
            new["namespace"] = entry.namespace
        models.append(new)
    return {**content, "models": models}


def _comparable(content: Dict[str, Any], is_moved: bool) -> Dict[str, Any]:
    """A world's value, in another folder without the names of its files."""
    comparable = {**content, "models": content.get("models") or []}
    if is_moved:
        for key, name in (("layers", "map"), ("models", "model")):
            entries = comparable.get(key) or []
            comparable[key] = [
                {inner: value for inner, value in entry.items() if inner != name}
                for entry in entries
            ]
    return comparable

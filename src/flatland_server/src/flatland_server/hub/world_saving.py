"""The service that saves a world's changed models into its file: /save_world."""

import os
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, Iterable, List, Tuple

from flatland_server.config.input_files import replacing
from flatland_server.config.plain_nodes import to_content
from flatland_server.config.world_file_text import NewEntry, WorldFileText
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import FlatlandError, YamlError, counted, listed
from flatland_server.hub.client_edits import Changes
from flatland_server.hub.hub import Hub
from flatland_server.simulation.world_config import ModelEntry, WorldConfig


class WorldSaving:
    """Offers /save_world.

    The file is read as it is now, changed, and read again. It replaces the former one if it has
    the world's models, and nothing else in it has changed. The saved world is the one to which a
    reset leads from then on.

    Args:
        hub: hub that offers the service, and has the world.
    """

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._manager = hub.manager
        self._files = hub.files
        self._lock = threading.Lock()  # clients are served by several threads
        hub.offer("save_world", "flatland_msgs/SaveWorld", self._save_world)

    def _save_world(self, request: Any) -> Dict[str, Any]:
        with self._lock:
            return {"message": self._save(self._files.written_world(request.path))}

    def _save(self, path: Path) -> str:
        """Saves the world; returns what is saved where."""
        config, changes = self._hub.transport.call(
            lambda: (self._manager.world.config, self._hub.edits.changes)
        )
        if config.path is None:
            raise FlatlandError("the world was made without a file")
        with_file = [entry for entry in changes.added if entry.model.content is None]
        unsaved = [entry.name for entry in changes.added if entry not in with_file]
        saved = changes._replace(added=with_file)
        new = replace(
            config,
            models=saved.applied_to(config.models),
            model_folders=(path.parent, *config.model_folders[1:]),
            path=path,
            with_seed=None,  # it has the saved values, whatever the seed
        )
        content, expected = self._new_content(config, saved, path)
        self._write(new, content, expected, config)
        self._hub.transport.call(lambda: self._take_over(config, new))
        for tell in self._hub.on_open:
            tell(str(path))
        message = f"{counted(saved.number, 'changed model')} saved in {path}"
        if unsaved:
            message += f"; without a file, and not saved: {', '.join(unsaved)}"
        return message

    def _new_content(
        self, config: WorldConfig, changes: Changes, path: Path
    ) -> Tuple[bytes, Dict[str, Any]]:
        """The new text of a world's file, and the value that it should have."""
        assert config.path is not None
        preprocessor = self._preprocessor()
        config.read_again(None, preprocessor)  # it is still a world
        root = preprocessor.read(config.path)
        text = WorldFileText(config.path, root)
        folders = (path.parent, *config.model_folders[1:])
        added = [
            NewEntry(entry.name, entry.namespace, _name_of(entry, folders), entry.pose)
            for entry in changes.added
        ]
        value = to_content(root)
        models = filter(_is_enabled, value.get("models") or [])
        former = {model["name"]: model.get("pose") for model in models}
        text.change_models(
            {name: (former.get(name) or pose, pose) for name, pose in changes.poses.items()},
            changes.deleted,
            added,
        )
        if path.parent.resolve() != config.path.parent.resolve():
            text.name_files_from(config.path.parent)
        return text.content, _changed(value, changes, added)

    def _write(
        self, new: WorldConfig, content: bytes, expected: Dict[str, Any], former: WorldConfig
    ) -> None:
        """Writes a world file, if it can be read and has the models and the value that it should
        have.
        """
        path = new.path
        assert path is not None
        assert former.path is not None
        try:
            with replacing(path) as partial:
                with partial.open("xb") as file:
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
                is_moved = path.parent.resolve() != former.path.parent.resolve()
                if not self._is_as(partial, expected, is_moved):
                    raise FlatlandError(
                        f"{former.path}: the models are written in a way that they cannot be "
                        "changed without changing others: edit it by hand"
                    )
                self._require_models(partial, new, former)
                self._files.written_world(str(path))  # still
        except OSError as error:
            raise FlatlandError(f"cannot write {path}: {error.strerror}") from None

    def _is_as(self, path: Path, expected: Dict[str, Any], is_moved: bool) -> bool:
        """True if a file has a value."""
        try:
            found = to_content(self._preprocessor().read(path))
        except YamlError:
            return False
        return _comparable(found, is_moved) == _comparable(expected, is_moved)

    def _require_models(self, path: Path, new: WorldConfig, former: WorldConfig) -> None:
        """Checks that a world file can be loaded, and has the models of a world."""
        assert new.path is not None
        try:
            models = new.read_again(path, self._preprocessor()).models
        except YamlError as error:
            raise YamlError.of(
                replace(each, file=new.path) if each.file == path else each
                for each in error.problems
            ) from None
        if _kinds(models) != _kinds(new.models):
            expected, found = (
                listed([entry.name for entry in entries]) for entries in (new.models, models)
            )
            raise FlatlandError(
                f"{former.path}: its models have been changed since it was loaded: expected "
                f"{expected}; found {found}; /reload_world reads them, and drops unsaved changes"
            )

    def _take_over(self, former: WorldConfig, new: WorldConfig) -> None:
        """Makes the saved models those of the world's file."""
        manager = self._manager
        if manager.world.config is not former:
            return  # another world was opened meanwhile
        manager.world.contents.config = new
        if manager.history is not None:
            manager.history.restart()  # its states are of the former file

    def _preprocessor(self) -> YamlPreprocessor:
        return YamlPreprocessor(self._manager.transport.get_param, self._manager.world.seed)


def _kinds(models: Iterable[ModelEntry]) -> List[Tuple[str, ...]]:
    """The names of models, their namespaces and their files, if they are in files of their own."""
    return sorted(
        (each.name, each.namespace, "" if each.is_inline else os.path.realpath(each.model.path))
        for each in models
    )


def _name_of(entry: ModelEntry, folders: Tuple[Path, ...]) -> str:
    """The name of a model's file in a world file: as short as it is found there."""
    path = Path(os.path.abspath(entry.model.path))
    for folder in folders:
        if folder.resolve() in path.parents:
            return path.relative_to(folder.resolve()).as_posix()
    return str(path)


def _is_enabled(model: Dict[str, Any]) -> bool:
    return model.get("enabled", True) is not False


def _changed(content: Dict[str, Any], changes: Changes, added: List[NewEntry]) -> Dict[str, Any]:
    """The value of a world's file with changed models."""
    models = []
    for model in content.get("models") or []:
        name = model["name"] if _is_enabled(model) else None
        if name in changes.deleted:
            continue
        if name in changes.poses:
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

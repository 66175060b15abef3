"""The services for models, and the topic `move_model`."""

import logging
from contextlib import contextmanager
from functools import partial
from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple, TypeVar

from flatland_server.exceptions import FlatlandError, ModelError, shortened
from flatland_server.geometry import Pose
from flatland_server.hub.client_edits import Edit
from flatland_server.hub.client_files import EntryError
from flatland_server.hub.hub import Action, Hub
from flatland_server.messages.conversions import FRAME_ID, yaw_of
from flatland_server.messages.message_types import get
from flatland_server.messages.model_markers import preview
from flatland_server.models.model import ModelText
from flatland_server.simulation.world_config import ModelEntry, ModelSource

logger = logging.getLogger(__name__)

MarkerArray = get("visualization_msgs/MarkerArray")

T = TypeVar("T")

_Source = Callable[[Any], ModelSource]
"""Finds the model that a request of SpawnModel names."""

_NOT_REGISTERED = "spawned; its topics can be used when the ROS master answers"


class ModelServices:
    """Offers the services that spawn, delete, move and show models, and obeys `move_model`.

    These edits are undone by /undo, and redone by /redo.

    A model within a wall or another model is spawned all the same: `success` is true, and
    `message` is a warning; otherwise `message` is empty.

    Args:
        hub: hub that offers the services, and has the models.
        initial_pose: name of the model that the topic `initialpose` moves; empty if none.
    """

    def __init__(self, hub: Hub, initial_pose: str = "") -> None:
        self._hub = hub
        self._world = hub.world
        self._edits = hub.edits
        self._transport = hub.transport
        self._files = hub.files
        self._streamed: Optional[Edit] = None  # by messages
        actions: Dict[str, Tuple[str, Action]] = {
            "spawn_model": ("SpawnModel", partial(self._spawn_model, self._file)),
            "spawn_model_from_string": ("SpawnModel", partial(self._spawn_model, _text)),
            "spawn_models": ("SpawnModels", partial(self._spawn_models, self._file)),
            "spawn_models_from_string": ("SpawnModels", partial(self._spawn_models, _text)),
            "delete_model": ("DeleteModel", self._delete_model),
            "delete_models": ("DeleteModels", self._delete_models),
            "move_model": ("MoveModel", self._move_model),
            "get_model_markers": ("GetModelMarkers", self._get_markers),
        }
        for name, (kind, action) in actions.items():
            hub.offer(name, f"flatland_msgs/{kind}", action)
        hub.offer("undo", "std_srvs/Trigger", lambda _: self._revert("Undone", self._edits.undo))
        hub.offer("redo", "std_srvs/Trigger", lambda _: self._revert("Redone", self._edits.redo))
        hub.obey("move_model", "flatland_msgs/MoveModelMsg", self._obey_move)
        if initial_pose:
            hub.obey(
                "initialpose",
                "geometry_msgs/PoseWithCovarianceStamped",
                partial(self._obey_initial_pose, initial_pose),
            )

    def _spawn_model(self, source: _Source, request: Any) -> Dict[str, Any]:
        return {"message": self._spawn(lambda: self._read(request, source), self._add_one)}

    def _spawn_models(self, source: _Source, request: Any) -> Dict[str, Any]:
        return {"message": self._spawn(lambda: self._read_all(request, source), self._add_all)}

    def _file(self, model: Any) -> ModelSource:
        return self._files.model_file(model.yaml_path)

    def _read(self, model: Any, source: _Source) -> ModelEntry:
        """Reads a model, which has the fields of a request of SpawnModel."""
        pose = _to_pose(model.pose)
        return self._world.read_model_entry(source(model), model.name, model.ns, pose)

    def _read_all(self, request: Any, source: _Source) -> List[ModelEntry]:
        entries = []
        for index, model in enumerate(request.models):
            with _naming_entry("models", index, model.name):
                entries.append(self._read(model, source))
        return entries

    def _spawn(self, read: Callable[[], T], add: Callable[[T], str]) -> str:
        """Reads on this thread, adds on the simulation's; returns a warning, or an empty string."""
        registry = self._world.registry
        content = read()

        def add_to_this_world() -> str:
            if self._world.registry is not registry:
                raise ModelError(
                    "the world was reloaded while the model's file was read; try again"
                )
            with self._transport.registration():
                return add(content)

        warning = self._transport.call(add_to_this_world)
        if warning:
            logger.warning("spawn_model: %s", warning)
        if not self._transport.wait_until_registered():
            warning = "; ".join(filter(None, (warning, _NOT_REGISTERED)))
        return warning

    def _add(self, entry: ModelEntry) -> str:
        """Adds a model; returns a warning, or an empty string."""
        return self._world.overlap_warning(self._edits.spawn(entry))

    def _add_one(self, entry: ModelEntry) -> str:
        with self._edits.edit([entry.name]):
            return self._add(entry)

    def _add_all(self, entries: List[ModelEntry]) -> str:
        """Adds models: all, or none; returns their warnings, or an empty string."""
        warnings = []
        with self._edits.edit([entry.name for entry in entries]):
            for index, entry in enumerate(entries):
                with _naming_entry("models", index, entry.name):
                    warnings.append(self._add(entry))
        return "; ".join(filter(None, warnings))

    def _delete_model(self, request: Any) -> None:
        self._hub.change(lambda: self._edits.delete([self._world.get_model(request.name).name]))

    def _delete_models(self, request: Any) -> None:
        def delete() -> None:
            for index, name in enumerate(request.name):
                with _naming_entry("name", index, name):
                    self._world.get_model(name)
                    if name in request.name[:index]:
                        raise ModelError("the name is given twice")
            self._edits.delete(request.name)

        self._hub.change(delete)

    def _move_model(self, request: Any) -> None:
        pose = _to_pose(request.pose)
        self._transport.call(lambda: self._edits.move(request.name, pose))

    def _obey_move(self, message: Any) -> None:
        """Moves a model; as one edit with the message before, if that was for the same model."""
        edit = self._streamed
        if edit is not None and message.name not in edit.before:
            edit = None
        self._streamed = self._edits.move(message.name, _to_pose(message.pose), edit)

    def _obey_initial_pose(self, name: str, message: Any) -> None:
        """Moves a model to a pose in the map, as a localiser is told where the robot is."""
        frame = message.header.frame_id.lstrip("/")
        if frame not in ("", FRAME_ID):
            raise ModelError(f"expected a pose in {FRAME_ID}, found {shortened(frame)}")
        pose = message.pose.pose
        x, y, yaw = pose.position.x, pose.position.y, yaw_of(pose.orientation)
        self._edits.move(name, Pose(x, y, yaw))

    def _revert(self, done: str, action: Callable[[], str]) -> Dict[str, Any]:
        return {"message": f"{done}: {self._hub.change(action)}"}

    def _get_markers(self, request: Any) -> Dict[str, Any]:
        markers = preview(self._world.read_model(self._files.model_file(request.yaml_path)))
        return {"markers": MarkerArray(markers)}


@contextmanager
def _naming_entry(key: str, index: int, name: str) -> Iterator[None]:
    """A context that adds the name of an entry of the request's list to errors."""
    try:
        yield
    except FlatlandError as error:
        raise EntryError(f'{key}[{index}] "{shortened(name)}"', error) from error


def _text(model: Any) -> ModelSource:
    return ModelText(model.yaml_path, model.name)


def _to_pose(pose: Any) -> Pose:
    return Pose(pose.x, pose.y, pose.theta)

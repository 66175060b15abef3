"""The services for models, and the topic `move_model`."""

import logging
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import Any, Callable, ContextManager, Dict, Iterator, List, Optional, Tuple

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

_Source = Callable[[Any], ModelSource]
"""Finds the model that a request of SpawnModel names."""
_Naming = Callable[[int, str], ContextManager[None]]
"""A context for an entry of a request's list, by its index and name; errors name the entry."""

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
        return self._spawn(source, [request], lambda index, name: nullcontext())

    def _spawn_models(self, source: _Source, request: Any) -> Dict[str, Any]:
        return self._spawn(source, request.models, partial(_naming_entry, "models"))

    def _file(self, model: Any) -> ModelSource:
        return self._files.model_file(model.yaml_path)

    def _spawn(self, source: _Source, models: List[Any], naming: _Naming) -> Dict[str, Any]:
        """Reads models on this thread, and adds them on the simulation's: all, or none.

        Args:
            source: finds each model.
            models: have the fields of a request of SpawnModel.
            naming: the context for each, by its index and name.
        """
        world = self._world
        registry = world.registry
        entries = []
        for index, model in enumerate(models):
            with naming(index, model.name):
                pose = _to_pose(model.pose)
                entry = world.read_model_entry(source(model), model.name, model.ns, pose)
                entries.append(entry)

        def add() -> str:
            if world.registry is not registry:
                raise ModelError(
                    "the world was reloaded while the model's file was read; try again"
                )
            with self._transport.registration():
                return self._add(entries, naming)

        warning = self._transport.call(add)
        if warning:
            logger.warning("spawn_model: %s", warning)
        if not self._transport.wait_until_registered():
            warning = "; ".join(filter(None, (warning, _NOT_REGISTERED)))
        return {"message": warning}

    def _add(self, entries: List[ModelEntry], naming: _Naming) -> str:
        """Adds models: all, or none; returns their warnings, or an empty string."""
        before = set(self._world.models)
        warnings = []
        try:
            with self._edits.edit([entry.name for entry in entries]):
                for index, entry in enumerate(entries):
                    with naming(index, entry.name):
                        warnings.append(self._world.overlap_warning(self._edits.spawn(entry)))
        except BaseException:
            self._edits.discard([name for name in self._world.models if name not in before])
            raise
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

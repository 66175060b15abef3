"""The services for models, and the topic `move_model`."""

from contextlib import contextmanager
from typing import Any, Callable, Iterable, Iterator, List, TypeVar

import rospy
from flatland_msgs.msg import MoveModelMsg
from flatland_msgs.srv import (
    DeleteModel,
    DeleteModelRequest,
    DeleteModelResponse,
    DeleteModels,
    DeleteModelsRequest,
    DeleteModelsResponse,
    GetModelMarkers,
    GetModelMarkersRequest,
    GetModelMarkersResponse,
    MoveModel,
    MoveModelRequest,
    MoveModelResponse,
    SpawnModel,
    SpawnModelRequest,
    SpawnModelResponse,
    SpawnModels,
    SpawnModelsRequest,
    SpawnModelsResponse,
)
from geometry_msgs.msg import Pose2D
from visualization_msgs.msg import MarkerArray

from flatland_server.exceptions import FlatlandError, ModelError, shortened
from flatland_server.geometry import Pose
from flatland_server.messages.model_markers import preview
from flatland_server.models.model import ModelText
from flatland_server.ros.client_files import ClientFiles, EntryError, told
from flatland_server.ros.ros_transport import REGISTRATION_LIMIT, RosTransport
from flatland_server.ros.state_services import Offer
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import ModelEntry, ModelSource

T = TypeVar("T")

_NOT_REGISTERED = "spawned; its topics can be used when the ROS master answers"


class ModelServices:
    """Offers the services that spawn, delete, move and show models, and subscribes to `move_model`.

    A model within a wall or another model is spawned all the same: `success` is true, and
    `message` is a warning; otherwise `message` is empty.

    Args:
        world: has the models.
        transport: hands calls over to the simulation's thread.
        files: finds the files that clients name.
        offer: offers a service; see `ServiceManager`.
    """

    def __init__(
        self, world: World, transport: RosTransport, files: ClientFiles, offer: Offer
    ) -> None:
        self._world = world
        self._transport = transport
        self._files = files
        self._last_warning = ""
        offer("spawn_model", SpawnModel, SpawnModelResponse, self._spawn_model)
        offer("spawn_model_from_string", SpawnModel, SpawnModelResponse, self._spawn_from_string)
        offer("spawn_models", SpawnModels, SpawnModelsResponse, self._spawn_models)
        offer("delete_model", DeleteModel, DeleteModelResponse, self._delete_model)
        offer("delete_models", DeleteModels, DeleteModelsResponse, self._delete_models)
        offer("move_model", MoveModel, MoveModelResponse, self._move_model)
        offer("get_model_markers", GetModelMarkers, GetModelMarkersResponse, self._get_markers)
        transport.subscribe("move_model", MoveModelMsg, self._receive_move)

    def _spawn_model(self, request: SpawnModelRequest) -> SpawnModelResponse:
        def read() -> ModelEntry:
            return self._read(request, self._files.model_file(request.yaml_path))

        return SpawnModelResponse(True, self._spawn(read, self._add))

    def _spawn_from_string(self, request: SpawnModelRequest) -> SpawnModelResponse:
        source = ModelText(request.yaml_path, request.name)
        return SpawnModelResponse(True, self._spawn(lambda: self._read(request, source), self._add))

    def _spawn_models(self, request: SpawnModelsRequest) -> SpawnModelsResponse:
        def read() -> List[ModelEntry]:
            entries = []
            for index, model in enumerate(request.models):
                with _naming_entry("models", index, model.name):
                    entries.append(self._read(model, self._files.model_file(model.yaml_path)))
            return entries

        return SpawnModelsResponse(True, self._spawn(read, self._add_all))

    def _read(self, model: Any, source: ModelSource) -> ModelEntry:
        """Reads a model, which has the fields of a `SpawnModelRequest`."""
        return self._world.read_model_entry(source, model.name, model.ns, _to_pose(model.pose))

    def _spawn(self, read: Callable[[], T], add: Callable[[T], str]) -> str:
        """Reads on this thread, adds on the simulation's; returns a warning, or an empty string."""
        registry = self._world.registry
        content = read()

        def add_to_this_world() -> str:
            if self._world.registry is not registry:
                raise ModelError(
                    "the world was reloaded while the model's file was read; try again"
                )
            with self._transport.rospy_calls.batch_registration():
                return add(content)

        warning = self._transport.call(add_to_this_world)
        if warning:
            rospy.logwarn("spawn_model: %s", warning)
        if not self._transport.rospy_calls.wait_until_registered(REGISTRATION_LIMIT):
            warning = "; ".join(filter(None, (warning, _NOT_REGISTERED)))
        return warning

    def _add(self, entry: ModelEntry) -> str:
        """Adds a model; returns a warning, or an empty string."""
        return self._world.overlap_warning(self._world.add_model(entry))

    def _add_all(self, entries: List[ModelEntry]) -> str:
        """Adds models: all, or none; returns their warnings, or an empty string."""
        before = set(self._world.models)
        warnings = []
        try:
            for index, entry in enumerate(entries):
                with _naming_entry("models", index, entry.name):
                    warnings.append(self._add(entry))
        except BaseException:
            self._remove([name for name in self._world.models if name not in before])
            raise
        return "; ".join(filter(None, warnings))

    def _delete_model(self, request: DeleteModelRequest) -> None:
        self._transport.call(lambda: self._world.delete_model(request.name))
        self._transport.rospy_calls.wait_until_registered(REGISTRATION_LIMIT)

    def _delete_models(self, request: DeleteModelsRequest) -> None:
        def delete() -> None:
            for index, name in enumerate(request.name):
                with _naming_entry("name", index, name):
                    self._world.get_model(name)
                    if name in request.name[:index]:
                        raise ModelError("the name is given twice")
            self._remove(request.name)

        self._transport.call(delete)
        self._transport.rospy_calls.wait_until_registered(REGISTRATION_LIMIT)

    def _remove(self, names: Iterable[str]) -> None:
        """Deletes models, unless plugins of one have deleted another."""
        for name in names:
            if name in self._world.models:
                self._world.delete_model(name)

    def _move_model(self, request: MoveModelRequest) -> None:
        pose = _to_pose(request.pose)
        self._transport.call(lambda: self._world.move_model(request.name, pose))

    def _receive_move(self, message: MoveModelMsg) -> None:
        """Moves a model; warns of a message that it cannot obey, once of equal ones."""
        warning = ""
        try:
            self._world.move_model(message.name, _to_pose(message.pose))
        except (FlatlandError, ValueError) as error:
            warning = told(error)
            if warning != self._last_warning:
                rospy.logwarn("%s: %s", rospy.resolve_name("move_model"), warning)
        self._last_warning = warning

    def _get_markers(self, request: GetModelMarkersRequest) -> GetModelMarkersResponse:
        markers = preview(self._world.read_model(self._files.model_file(request.yaml_path)))
        return GetModelMarkersResponse(success=True, markers=MarkerArray(markers))


@contextmanager
def _naming_entry(key: str, index: int, name: str) -> Iterator[None]:
    """A context whose errors name an entry of a request's list."""
    try:
        yield
    except FlatlandError as error:
        raise EntryError(f'{key}[{index}] "{shortened(name)}"', error) from error


def _to_pose(pose: Pose2D) -> Pose:
    return Pose(pose.x, pose.y, pose.theta)

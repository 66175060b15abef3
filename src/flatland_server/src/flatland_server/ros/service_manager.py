"""The server's ROS services. Errors are reported as `ModelError: a model named ...`."""

from typing import Any, Callable, Type

import rospy
from flatland_msgs.srv import (
    ChangeRate,
    ChangeRateRequest,
    ChangeRateResponse,
    DeleteModel,
    DeleteModelRequest,
    DeleteModelResponse,
    GetModelMarkers,
    GetModelMarkersRequest,
    GetModelMarkersResponse,
    MoveModel,
    MoveModelRequest,
    MoveModelResponse,
    SpawnModel,
    SpawnModelRequest,
    SpawnModelResponse,
)
from geometry_msgs.msg import Pose2D
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse
from visualization_msgs.msg import MarkerArray

from flatland_server.exceptions import FlatlandError, ModelError
from flatland_server.geometry import Pose
from flatland_server.messages.model_markers import preview
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.ros.client_files import ClientFiles, told
from flatland_server.ros.ros_transport import REGISTRATION_LIMIT, RosTransport
from flatland_server.ros.state_services import StateServices
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world_config import ModelEntry

_NOT_REGISTERED = "spawned; its topics can be used when the ROS master answers"


class ServiceManager:
    """Offers the services for models, for pausing and for the rate.

    rospy calls a service on a thread of its own. Files are read there; what changes the simulation
    runs on the simulation's thread, between two steps.

    The `message` of an error begins with the name of an exception class (see
    `flatland_server.exceptions`; `ValueError` for a rate), for programs to tell errors apart.

    A model within a wall or another model is spawned all the same: `success` is true, and
    `message` is a warning; otherwise `message` is empty.
    """

    def __init__(
        self, manager: SimulationManager, transport: RosTransport, files: ClientFiles
    ) -> None:
        self._manager = manager
        self._files = files
        self._world = manager.world
        self._transport = transport
        self._offer("spawn_model", SpawnModel, SpawnModelResponse, self._spawn_model)
        self._offer("delete_model", DeleteModel, DeleteModelResponse, self._delete_model)
        self._offer("move_model", MoveModel, MoveModelResponse, self._move_model)
        self._offer("change_rate", ChangeRate, ChangeRateResponse, self._change_rate)
        self._offer(
            "get_model_markers", GetModelMarkers, GetModelMarkersResponse, self._get_model_markers
        )
        StateServices(manager, transport, files, self._offer)
        self._offer_empty("pause", manager.pause)
        self._offer_empty("resume", manager.resume)
        self._offer_empty("toggle_pause", manager.toggle_pause)

    def _offer(
        self, name: str, service: Any, response: Type[Any], action: Callable[[Any], Any]
    ) -> None:
        """Offers a service.

        Args:
            name: of the service.
            service: its type.
            response: its response's type, with `success` and `message`.
            action: called with the request; returns the response, or None for success.
        """

        def handle(request: Any) -> Any:
            try:
                return action(request) or response(success=True)
            except (FlatlandError, ValueError) as error:
                message = told(error)
                rospy.logwarn("%s: %s", name, message)
                return response(success=False, message=message)

        rospy.Service(name, service, handle)

    def _offer_empty(self, name: str, action: Callable[[], None]) -> None:
        def handle(request: EmptyRequest) -> EmptyResponse:
            self._transport.call(action)
            return EmptyResponse()

        rospy.Service(name, Empty, handle)

    def _spawn_model(self, request: SpawnModelRequest) -> SpawnModelResponse:
        registry = self._world.registry
        path = self._files.model_file(request.yaml_path)
        entry = self._world.read_model_entry(path, request.name, request.ns, _to_pose(request.pose))
        warning = self._transport.call(lambda: self._add_model(entry, registry))
        if warning:
            rospy.logwarn("spawn_model: %s", warning)
        if not self._transport.rospy_calls.wait_until_registered(REGISTRATION_LIMIT):
            warning = "; ".join(filter(None, (warning, _NOT_REGISTERED)))
        return SpawnModelResponse(success=True, message=warning)

    def _add_model(self, entry: ModelEntry, registry: CollisionFilterRegistry) -> str:
        """Adds a model; returns a warning, or the empty string."""
        if self._world.registry is not registry:
            raise ModelError("the world was reloaded while the model's file was read; try again")
        with self._transport.rospy_calls.batch_registration():
            return self._world.overlap_warning(self._world.add_model(entry))

    def _delete_model(self, request: DeleteModelRequest) -> None:
        self._transport.call(lambda: self._world.delete_model(request.name))
        self._transport.rospy_calls.wait_until_registered(REGISTRATION_LIMIT)

    def _move_model(self, request: MoveModelRequest) -> None:
        pose = _to_pose(request.pose)
        self._transport.call(lambda: self._world.move_model(request.name, pose))

    def _change_rate(self, request: ChangeRateRequest) -> None:
        self._transport.call(lambda: self._manager.change_rate(request.rate))

    def _get_model_markers(self, request: GetModelMarkersRequest) -> GetModelMarkersResponse:
        markers = preview(self._world.read_model(self._files.model_file(request.yaml_path)))
        return GetModelMarkersResponse(success=True, markers=MarkerArray(markers))


def _to_pose(pose: Pose2D) -> Pose:
    return Pose(pose.x, pose.y, pose.theta)

"""The server's ROS services. Each runs between steps, and says what was wrong if something was."""

from pathlib import Path
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

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.messages.model_markers import preview
from flatland_server.ros.ros_transport import RosTransport
from flatland_server.ros.rospy_patches.batch_registration import batch_registration
from flatland_server.simulation.simulation_manager import SimulationManager


class ServiceManager:
    """Offers the services for models, for pausing and for the rate."""

    def __init__(self, manager: SimulationManager, transport: RosTransport) -> None:
        self._manager = manager
        self._world = manager.world
        self._transport = transport
        self._offer("spawn_model", SpawnModel, SpawnModelResponse, self._spawn_model)
        self._offer("delete_model", DeleteModel, DeleteModelResponse, self._delete_model)
        self._offer("move_model", MoveModel, MoveModelResponse, self._move_model)
        self._offer("change_rate", ChangeRate, ChangeRateResponse, self._change_rate)
        rospy.Service("get_model_markers", GetModelMarkers, self._get_model_markers)
        self._offer_empty("pause", manager.pause)
        self._offer_empty("resume", manager.resume)
        self._offer_empty("toggle_pause", manager.toggle_pause)

    def _offer(
        self, name: str, service: Any, response: Type[Any], action: Callable[[Any], None]
    ) -> None:
        def handle(request: Any) -> Any:
            try:
                self._transport.call(lambda: action(request))
            except (FlatlandError, ValueError) as error:
                rospy.logwarn("%s: %s", name, error)
                return response(success=False, message=str(error))
            return response(success=True, message="")

        rospy.Service(name, service, handle)

    def _offer_empty(self, name: str, action: Callable[[], None]) -> None:
        def handle(request: EmptyRequest) -> EmptyResponse:
            self._transport.call(action)
            return EmptyResponse()

        rospy.Service(name, Empty, handle)

    def _spawn_model(self, request: SpawnModelRequest) -> None:
        with batch_registration():
            self._world.spawn_model(
                Path(request.yaml_path), request.name, request.ns, _to_pose(request.pose)
            )

    def _delete_model(self, request: DeleteModelRequest) -> None:
        self._world.delete_model(request.name)

    def _move_model(self, request: MoveModelRequest) -> None:
        self._world.move_model(request.name, _to_pose(request.pose))

    def _change_rate(self, request: ChangeRateRequest) -> None:
        self._manager.change_rate(request.rate)

    def _get_model_markers(self, request: GetModelMarkersRequest) -> GetModelMarkersResponse:
        """Reads the file on the caller's thread: nothing of the world is touched."""
        try:
            markers = preview(self._world.read_model(Path(request.yaml_path)))
        except FlatlandError as error:
            return GetModelMarkersResponse(success=False, message=str(error))
        return GetModelMarkersResponse(success=True, markers=MarkerArray(markers))


def _to_pose(pose: Pose2D) -> Pose:
    return Pose(pose.x, pose.y, pose.theta)

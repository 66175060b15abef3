"""The server's ROS services. Errors are reported as `ModelError: a model named ...`."""

from typing import Any, Callable, Type

import rospy
from flatland_msgs.srv import ChangeRate, ChangeRateRequest, ChangeRateResponse, StepWorld
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse

from flatland_server.exceptions import FlatlandError
from flatland_server.ros.client_files import ClientFiles, told
from flatland_server.ros.model_services import ModelServices
from flatland_server.ros.ros_transport import RosTransport
from flatland_server.ros.state_services import StateServices
from flatland_server.simulation.simulation_manager import SimulationManager


class ServiceManager:
    """Offers the services for models, for pausing and for the rate.

    rospy calls a service on a thread of its own. Files are read there; what changes the simulation
    runs on the simulation's thread, between two steps.

    The `message` of an error begins with the name of an exception class (see
    `flatland_server.exceptions`; `ValueError` for a rate), for programs to tell errors apart.

    Args:
        manager: the simulation.
        transport: hands calls over to the simulation's thread.
        files: finds the files that clients name.
        control_period: simulated time of a call of /step_world [s].
    """

    def __init__(
        self,
        manager: SimulationManager,
        transport: RosTransport,
        files: ClientFiles,
        control_period: float,
    ) -> None:
        self._manager = manager
        self._transport = transport
        ModelServices(manager.world, transport, files, self._offer)
        states = StateServices(manager, transport, files, self._offer, control_period)
        rospy.Service("step_world", StepWorld, states.step_world)
        self._offer("change_rate", ChangeRate, ChangeRateResponse, self._change_rate)
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

    def _change_rate(self, request: ChangeRateRequest) -> None:
        self._transport.call(lambda: self._manager.change_rate(request.rate))

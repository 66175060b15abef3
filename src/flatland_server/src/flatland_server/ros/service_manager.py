"""The server's ROS services. Errors are reported as `ModelError: a model named ...`."""

from concurrent.futures import Future
from typing import Any, Callable, ContextManager, TypeVar

import rosgraph
import rospy

from flatland_server.messages import service_types
from flatland_server.ros.ros_transport import REGISTRATION_LIMIT, RosTransport
from flatland_server.ros.rospy_patches.master_calls import NO_ANSWER, Master
from flatland_server.serving.service_host import Action, ServiceError, ServiceHost, answer

T = TypeVar("T")


class RosServiceHost(ServiceHost):
    """Offers services over ROS.

    rospy calls a service on a thread of its own. Files are read there; what changes the simulation
    runs on the simulation's thread, between two steps.

    The `message` of an error begins with the name of an exception class (see
    `flatland_server.exceptions`; `ValueError` for a rate), for programs to tell errors apart.

    Args:
        transport: hands calls over to the simulation's thread.
    """

    def __init__(self, transport: RosTransport) -> None:
        self._transport = transport

    def offer(self, name: str, type_name: str, action: Action) -> None:
        service = service_types.get(type_name)

        def handle(request: Any) -> Any:
            try:
                response = answer(service, action, request)
            except ServiceError as error:
                rospy.logwarn("%s: %s", name, error)
                raise rospy.ServiceException(str(error)) from None
            if not getattr(response, "success", True):
                rospy.logwarn("%s: %s", name, response.message)
            return response

        rospy.Service(name, service.ros_class, handle)

    def call(self, function: Callable[[], T]) -> T:
        return self._transport.call(function)

    def wait(self, future: "Future[T]") -> T:
        return self._transport.wait(future)

    def registration(self) -> ContextManager[None]:
        return self._transport.rospy_calls.batch_registration()

    def wait_until_registered(self) -> bool:
        return self._transport.rospy_calls.wait_until_registered(REGISTRATION_LIMIT)

    def world_is_open(self, path: str) -> None:
        """Sets ~world_path, if the ROS master answers in time; it may be stopped, or dead."""
        name = "~world_path"
        try:
            Master(rosgraph.get_master_uri()).ask("setParam", rospy.resolve_name(name), path)
        except NO_ANSWER:
            rospy.logwarn("the ROS master does not answer: %s is not set to %s", name, path)

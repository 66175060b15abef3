"""The hub's services over ROS. Errors are reported as `ModelError: a model named ...`.

rospy calls a service on a thread of its own. The `message` of an error begins with the name of an
exception class (see `flatland_server.exceptions`; `ValueError` for a rate), for programs to tell
errors apart.
"""

from functools import partial
from typing import Any

import rosgraph
import rospy

from flatland_server.hub.hub import Hub, Service, ServiceError
from flatland_server.ros.rospy_patches.master_calls import NO_ANSWER, Master


def offer_services(hub: Hub) -> None:
    """Offers all services of a simulation."""
    for name, service in hub.services.items():
        rospy.Service(name, service.type.ros_class, partial(_handle, name, service))
    hub.on_open.append(_set_world_path)


def _handle(name: str, service: Service, request: Any) -> Any:
    try:
        response = service.answer(request)
    except ServiceError as error:
        rospy.logwarn("%s: %s", name, error)
        raise rospy.ServiceException(str(error)) from None
    if not getattr(response, "success", True):
        rospy.logwarn("%s: %s", name, response.message)
    return response


def _set_world_path(path: str) -> None:
    """Sets ~world_path, if the ROS master answers in time; it may be stopped, or dead."""
    name = "~world_path"
    try:
        Master(rosgraph.get_master_uri()).ask("setParam", rospy.resolve_name(name), path)
    except NO_ANSWER:
        rospy.logwarn("the ROS master does not answer: %s is not set to %s", name, path)

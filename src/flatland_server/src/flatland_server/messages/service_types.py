"""Service types by name: ROS's own classes where there is ROS, else our own.

SpawnModel = service_types.get("flatland_msgs/SpawnModel")
request = SpawnModel.request(yaml_path="robot.model.yaml", name="robot")
"""

import re
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from flatland_server.exceptions import MessageError, shortened
from flatland_server.messages.message_types import add, ros_class

_DEFINITIONS = Path(__file__).parent / "services"
"""Folders of .srv files, by package: those of flatland_msgs."""

_STANDARD = {
    "std_srvs/Empty": "---\n",
    "std_srvs/SetBool": "bool data\n---\nbool success\nstring message\n",
    "std_srvs/Trigger": "---\nbool success\nstring message\n",
}
_SEPARATOR = re.compile(r"^---+\s*$", re.MULTILINE)


class ServiceType(NamedTuple):
    """A type of services.

    Attributes:
        name: such as `flatland_msgs/SpawnModel`.
        request: the class of its requests.
        response: the class of its responses.
        ros_class: ROS's class for rospy; None without ROS.
    """

    name: str
    request: Any
    response: Any
    ros_class: Any = None


@lru_cache(maxsize=None)
def get(name: str) -> ServiceType:
    """A service type.

    Args:
        name: such as `flatland_msgs/SpawnModel`.

    Raises:
        MessageError: there is no such type.
    """
    package, _, bare = name.partition("/")
    cls = ros_class(name, "srv")
    if cls is not None:
        return ServiceType(name, cls._request_class, cls._response_class, cls)
    definition = _STANDARD.get(name)
    file = _DEFINITIONS / package / f"{bare}.srv"
    if definition is None and bare.isidentifier() and package.isidentifier() and file.is_file():
        definition = file.read_text(encoding="utf-8")
    if definition is None:
        raise MessageError(f'there is no service type "{shortened(name)}"')
    request, response = _SEPARATOR.split(definition, maxsplit=1)
    return ServiceType(name, add(f"{name}Request", request), add(f"{name}Response", response))

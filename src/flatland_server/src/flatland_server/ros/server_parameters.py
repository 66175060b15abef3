"""Parameters of nodes of ROS 1."""

from pathlib import Path
from typing import Any, NamedTuple, Optional

import rospy

from flatland_server.exceptions import FlatlandError
from flatland_server.hub.server_config import ServerConfig, flag


class RosConfig(NamedTuple):
    """The parameters of the node flatland_server."""

    server: ServerConfig
    rospy_patches: bool
    launch_file: Optional[Path]
    """The launch file that sets the parameters, to check its arguments."""


def read_config() -> RosConfig:
    """The parameters of the node flatland_server.

    Raises:
        FlatlandError: one is missing or invalid.
    """
    if not param("~world_path", ""):
        raise FlatlandError(_without_world())
    server = ServerConfig.read(param)
    launch_file = rospy.get_param("~launch_file", "")
    return RosConfig(
        server,
        flag(param, "~rospy_patches", True),
        Path(launch_file) if launch_file else None,
    )


def param(name: str, default: Any) -> Any:
    """The value of a parameter of the node, else of the namespace above, and so on to the root.

    A launch file clears what a former one has set on this master with a blank.
    """
    value = rospy.get_param(name, default)
    if isinstance(value, str) and not value.strip() and not isinstance(default, str):
        rospy.delete_param(name)
        value = default
    found = rospy.search_param(name[1:]) if value is default else None
    if found is None or found == rospy.resolve_name(name):
        return value
    rospy.loginfo("%s is not set: %s is used", name, found)
    return rospy.get_param(found, default)


def _without_world() -> str:
    """The error of a missing `~world_path`, with the parameters of that name that others have."""
    others = [
        name
        for name in rospy.get_param_names()
        if name.endswith("/world_path") and rospy.get_param(name, "")
    ]
    elsewhere = f"; others are set: {', '.join(others)}" if others else ""
    return (
        "the parameter ~world_path must be the path of a world file: "
        f"world_path:=PATH for roslaunch, _world_path:=PATH for rosrun{elsewhere}"
    )

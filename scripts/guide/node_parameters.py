"""The private parameters of nodes, with defaults: from their calls of `rospy.get_param`."""

from typing import Any, Callable, Dict, List, Tuple
from unittest import mock

import rospy

from flatland_navigation.parameters import NodeParameters
from flatland_server.ros.server_parameters import read_config

READERS: Dict[str, Callable[[], Any]] = {
    "flatland_server": read_config,
    "navigator": NodeParameters.read,
}
"""The function that reads a node's parameters, by node."""


def parameters_of(node: str) -> List[Tuple[str, Any]]:
    """The names of a node's parameters without `~`, in the order of reading, and their defaults."""
    found: Dict[str, Any] = {}

    def note(name: str, default: Any = None) -> Any:
        if name.startswith("~"):
            found[name[1:]] = default
        return "/world.yaml" if name.endswith("world_path") else default

    with mock.patch.multiple(rospy, get_param=note, search_param=lambda name: None):
        READERS[node]()
    return list(found.items())

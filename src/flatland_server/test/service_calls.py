"""Calls of the server's services, and queries to the master, for the rostests."""

import os
from typing import Any, Dict, List, NamedTuple, Set, Tuple

import rosgraph
import rospy
from flatland_msgs.srv import DeleteModel, MoveModel, SpawnModel
from geometry_msgs.msg import Pose2D

SERVER = "/flatland_server"


def call(name: str, service: Any, *arguments: Any) -> Any:
    """A service's answer."""
    rospy.wait_for_service(name, timeout=20)
    return rospy.ServiceProxy(name, service)(*arguments)


def spawn(
    path: "os.PathLike[str]",
    name: str,
    namespace: str = "",
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
) -> Any:
    """The answer of /spawn_model."""
    return call("/spawn_model", SpawnModel, os.fspath(path), name, namespace, Pose2D(x, y, yaw))


def move(name: str, x: float, y: float, yaw: float = 0.0) -> Any:
    """The answer of /move_model."""
    return call("/move_model", MoveModel, name, Pose2D(x, y, yaw))


def delete(name: str) -> Any:
    """The answer of /delete_model."""
    return call("/delete_model", DeleteModel, name)


class ServerTopics(NamedTuple):
    """The server's topics known to the master, except markers, which follow models with a delay."""

    published: Set[str]
    subscribed: Set[str]

    @classmethod
    def ask(cls) -> "ServerTopics":
        """The server's present topics."""
        published, subscribed, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        return cls(_of_server(published), _of_server(subscribed))

    def without(self, others: "ServerTopics") -> "ServerTopics":
        """The topics that are not among others."""
        return ServerTopics(self.published - others.published, self.subscribed - others.subscribed)


def _of_server(state: List[Tuple[str, List[str]]]) -> Set[str]:
    return {
        topic
        for topic, nodes in state
        if SERVER in nodes and not topic.startswith(f"{SERVER}/debug/")
    }


def topic_types() -> Dict[str, str]:
    """The types of all topics that the master knows."""
    return dict(rosgraph.Master(rospy.get_name()).getTopicTypes())

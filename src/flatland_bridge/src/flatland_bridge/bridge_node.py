"""The node bridge: shows the topics and services of a ROS master to clients of all protocols."""

import rospy

from flatland_bridge.budget import CLIENT_MEMORY
from flatland_bridge.ros_graph import RosGraph
from flatland_bridge.server import FOXGLOVE, ROSBRIDGE, serve_clients
from flatland_bridge.websocket_server import Access
from flatland_server.exceptions import FlatlandError
from flatland_server.hub import positive_param
from flatland_server.ros import init_node, rospy_patches, server_parameters

_PERIOD = 0.5
"""Real time between two looks for new topics and services [s]."""


def main() -> int:
    """Runs the node until it is shut down. Returns its exit code."""
    init_node("bridge")
    rospy_patches.install()  # a master or a subscriber that is stopped stops no client
    graph = RosGraph()
    try:
        token = rospy.get_param("~token", None)
        access = Access(
            str(rospy.get_param("~host", "127.0.0.1")),
            None if token is None else str(token),
            tuple(rospy.get_param("~origins", ())),
        )
        if not access.is_local:
            rospy.logwarn("everyone who can reach %s can control the simulation", access.host)
        graph.update()
        memory = int(
            positive_param(server_parameters.param, "~client_memory", CLIENT_MEMORY / 1e6) * 1e6
        )
        ports = (rospy.get_param("~port", 9090), rospy.get_param("~foxglove_port", 8765))
        clients = serve_clients(graph, *map(int, ports), access, memory)
    except FlatlandError as error:
        rospy.logfatal("%s", error)
        return 1
    rospy.set_param("~ports", clients.ports)
    rospy.loginfo("page: %s", clients.url(ROSBRIDGE, "http"))
    rospy.loginfo("Foxglove: %s", clients.url(FOXGLOVE, "ws"))
    try:
        while not rospy.is_shutdown():
            graph.update()
            rospy.rostime.wallsleep(_PERIOD)
    finally:
        clients.close()
    return 0

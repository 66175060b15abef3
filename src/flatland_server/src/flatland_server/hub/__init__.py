"""The topics and services of a server that are not plugins', over any transport. No rospy."""

from flatland_server.hub.assembly import open_hub
from flatland_server.hub.client_files import ClientFiles, told
from flatland_server.hub.hub import Action, Failures, Hub, Service
from flatland_server.hub.map_to_odom import MapToOdom
from flatland_server.hub.server_config import ServerConfig, positive, positive_param
from flatland_server.messages.conversions import FRAME_ID

__all__ = [
    "FRAME_ID",
    "Action",
    "ClientFiles",
    "Failures",
    "Hub",
    "MapToOdom",
    "ServerConfig",
    "Service",
    "open_hub",
    "positive",
    "positive_param",
    "told",
]

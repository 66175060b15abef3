"""Faster paths through rospy than its public interface offers, each behind a check.

Everything in flatland_server that reaches into rospy lies in this package.
It is written for rospy 1.15 to 1.17 (ROS Noetic). `install` checks, for each patch, that the
attributes and signatures it relies on exist. A patch that fails this check is left out: the server
then does the same through rospy's public interface, at a cost that is logged.
"""

import importlib
import logging
from dataclasses import replace
from typing import Dict, List

from flatland_server.ros.rospy_patches.rospy_calls import RospyCalls
from flatland_server.ros.rospy_patches.rospy_checks import UnknownRospyError

__all__ = ["PATCHES", "RospyCalls", "install"]

PATCHES: Dict[str, str] = {
    "nonblocking_connection": "each message costs two thread switches per subscriber",
    "registration": "worlds with many topics take longer to load; a master that hangs stops time",
    "tcpros_server": "a connection that sends nothing stops all services; subscribers may be "
    "delayed by seconds",
    "topic_polls": "each topic takes a file descriptor",
    "local_time": "this process receives its own /clock through a socket",
    "believed_lengths": "a message of a type with arrays of empty items may stop the process",
    "latched_topics": "the markers of models are not latched",
}
"""The modules of the patches, each with what it costs to do without it.

Two of them save time. A step of the office at 200 Hz takes 0.19 ms of processor time while a scan
and odometry are subscribed to, 0.27 ms without `local_time`, and 0.40 ms or more without
`nonblocking_connection`. The others have a test that fails without them.
"""

logger = logging.getLogger(__name__)


def install(is_wanted: bool = True) -> RospyCalls:
    """Puts all patches in place that this rospy allows; logs those that it does not.

    To be called after `rospy.init_node` and before any topic is opened.

    Args:
        is_wanted: whether to patch at all.

    Returns:
        The operations to use, each patched or plain.
    """
    if not is_wanted:
        logger.info("rospy is not patched: publishing and loading take longer")
        return RospyCalls()
    calls = RospyCalls()
    refused: List[str] = []
    for name, cost in PATCHES.items():
        try:
            module = importlib.import_module(f"{__name__}.{name}")
            calls = replace(calls, **module.install())
        except (ImportError, AttributeError, OSError, UnknownRospyError) as error:
            refused.append(f"{name} ({error}): {cost}")
    if refused:
        logger.warning("patches of rospy that are switched off: %s", "; ".join(refused))
    return calls

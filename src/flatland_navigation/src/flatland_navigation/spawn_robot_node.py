"""The node spawn_robot: spawns a robot, and deletes it at its end."""

import signal
import sys
import threading
from typing import Any

import rospy
from flatland_msgs.srv import DeleteModel, SpawnModel
from geometry_msgs.msg import Pose2D

from flatland_navigation.parameters import read_number
from flatland_server import FlatlandError

_DELETE_LIMIT = 2.0
"""Limit for the deletion [s]: the server may be ending, too."""


def main() -> int:
    """Spawns the model `~model` in the namespace `~namespace`, and names it after the namespace.

    Returns:
        The exit code: 1 if the robot could not be spawned.
    """
    ended = threading.Event()
    # rospy's own handlers would close the connections before the robot is deleted.
    rospy.init_node("spawn_robot", disable_signals=True)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    rospy.on_shutdown(ended.set)
    name = str(rospy.get_param("~namespace"))
    try:
        pose = Pose2D(*(read_number(key, 0.0) for key in ("x", "y", "yaw")))
        if not _wait_for_server(ended):
            return 0
        spawn(name, pose)
    except FlatlandError as error:
        rospy.logfatal("%s", error)
        return 1
    ended.wait()
    deletion = threading.Thread(target=_delete, args=(name,), daemon=True)
    deletion.start()
    deletion.join(_DELETE_LIMIT)
    rospy.signal_shutdown("the robot is deleted")
    return 0


def spawn(name: str, pose: Pose2D) -> None:
    """Spawns the model `~model`.

    Args:
        name: of the model, and its namespace.
        pose: where it is spawned.

    Raises:
        FlatlandError: the server refuses.
    """
    path = str(rospy.get_param("~model"))
    try:
        answer: Any = rospy.ServiceProxy("/spawn_model", SpawnModel)(path, name, name, pose)
    except rospy.ServiceException as error:
        raise FlatlandError(f"/spawn_model: {error}") from None
    if not answer.success:
        raise FlatlandError(answer.message)
    rospy.loginfo("%s spawned at (%g, %g)", name, pose.x, pose.y)


def _wait_for_server(ended: threading.Event) -> bool:
    """Waits for the server; false if the node ends before."""
    while not ended.is_set():
        try:
            rospy.wait_for_service("/spawn_model", timeout=1.0)
            return True
        except rospy.ROSException:
            rospy.loginfo_once("waiting for the server's service /spawn_model")
    return False


def _delete(name: str) -> None:
    try:
        rospy.ServiceProxy("/delete_model", DeleteModel)(name)
    except rospy.ServiceException:
        return  # the server has ended


if __name__ == "__main__":
    sys.exit(main())

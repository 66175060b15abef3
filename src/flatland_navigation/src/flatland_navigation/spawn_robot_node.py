"""The node spawn_robot: spawns a robot, and deletes it at its end."""

import math
import signal
import sys
import threading
from typing import Any

import rospy
from flatland_msgs.srv import DeleteModel, SpawnModel
from geometry_msgs.msg import Pose2D

_DELETE_LIMIT = 2.0
"""How long the deletion may take [s]; the server may be ending, too."""


def main() -> int:
    """Spawns the model `~model` in the namespace `~namespace`, whose name it also gets.

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
    pose = Pose2D(*(float(rospy.get_param(f"~{key}", 0.0)) for key in ("x", "y", "yaw")))
    if not all(math.isfinite(value) for value in (pose.x, pose.y, pose.theta)):
        rospy.logfatal("expected a pose of finite numbers, found %s", pose)
        return 1
    if not _wait_for_server(ended):
        return 0
    path = str(rospy.get_param("~model"))
    answer: Any = rospy.ServiceProxy("/spawn_model", SpawnModel)(path, name, name, pose)
    if not answer.success:
        rospy.logfatal("%s", answer.message)
        return 1
    rospy.loginfo("%s spawned at (%g, %g)", name, pose.x, pose.y)
    ended.wait()
    deletion = threading.Thread(target=_delete, args=(name,), daemon=True)
    deletion.start()
    deletion.join(_DELETE_LIMIT)
    rospy.signal_shutdown("the robot is deleted")
    return 0


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

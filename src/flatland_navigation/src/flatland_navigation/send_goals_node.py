"""The node send_goals: sends a robot to one goal after another, with move_base or the navigator."""

import sys
import time
from typing import List

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

from flatland_navigation.parameters import read_goals
from flatland_server import FlatlandError, Pose, fill_pose
from flatland_server.ros import init_node

_PATIENCE = 10.0  # s of simulated time between two warnings


def main() -> int:
    """Sends the goals of `~goals`.

    If `~score` is set, it waits for the node score first. If `~loop` is set, they are sent
    again and again, until none of them is reached: goals that are refused would otherwise be
    sent again at once, for ever.

    Returns:
        The exit code: 1 if a goal was not reached.
    """
    init_node("send_goals")
    try:
        goals = read_goals()
    except FlatlandError as error:
        rospy.logfatal("%s", error)
        return 1
    client = actionlib.SimpleActionClient("move_base", MoveBaseAction)
    while not client.wait_for_server(rospy.Duration(_PATIENCE)):
        if rospy.is_shutdown():
            return 0
        rospy.logwarn("waiting for %s, a navigator or move_base", rospy.resolve_name("move_base"))
    rospy.on_shutdown(client.cancel_all_goals)
    if rospy.get_param("~score", False):
        _wait_for_listeners(client, 2)  # move_base, and the node score
    reached = _send_all(client, goals)
    while reached and rospy.get_param("~loop", False) and not rospy.is_shutdown():
        reached = _send_all(client, goals)
    if rospy.is_shutdown():
        return 0
    rospy.loginfo("%d of %d goals reached", reached, len(goals))
    return 0 if reached == len(goals) else 1


def _wait_for_listeners(client: actionlib.SimpleActionClient, count: int) -> None:
    """Waits until so many nodes receive goals; each would miss earlier ones."""
    while client.action_client.pub_goal.get_num_connections() < count and not rospy.is_shutdown():
        time.sleep(0.02)


def _send_all(client: actionlib.SimpleActionClient, goals: List[Pose]) -> int:
    """Sends goals in order. Returns how many were reached."""
    reached = 0
    for index, pose in enumerate(goals):
        name = f"goal {index + 1} of {len(goals)}, ({pose.x:g}, {pose.y:g})"
        goal = MoveBaseGoal()
        goal.target_pose.header.frame_id = rospy.get_param("~map_frame", "map")
        fill_pose(goal.target_pose.pose, pose)
        client.send_goal(goal)
        client.wait_for_result()
        if rospy.is_shutdown():
            break
        if client.get_state() == GoalStatus.SUCCEEDED:
            reached += 1
            rospy.loginfo("%s: reached", name)
        else:
            rospy.logwarn("%s: not reached: %s", name, client.get_goal_status_text())
    return reached


if __name__ == "__main__":
    sys.exit(main())

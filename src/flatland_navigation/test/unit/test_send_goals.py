"""The order in which goals are sent, with a stand-in for the action's client."""

import actionlib
import pytest
import rospy
from actionlib_msgs.msg import GoalStatus

from flatland_navigation import send_goals_node

GOALS = [[1, 0, 0], [2, 0, 0]]


class Client:
    """Reaches a number of goals, and aborts all later ones."""

    def __init__(self, reaches):
        self._reaches = reaches
        self.sent = []

    def wait_for_server(self, timeout):
        return True

    def send_goal(self, goal):
        self.sent.append(goal.target_pose.pose.position.x)

    def wait_for_result(self):
        assert len(self.sent) < 100, "goals are sent for ever"

    def get_state(self):
        return GoalStatus.SUCCEEDED if len(self.sent) <= self._reaches else GoalStatus.ABORTED

    def get_goal_status_text(self):
        return "in a wall"

    def cancel_all_goals(self):
        pass


@pytest.fixture
def send(monkeypatch):
    """Runs the node with a client; returns its exit code and the goals that were sent, by x."""

    def run(reaches, loop):
        client = Client(reaches)
        params = {"~goals": GOALS, "~loop": loop}
        monkeypatch.setattr(send_goals_node, "init_node", lambda name: None)
        monkeypatch.setattr(rospy, "on_shutdown", lambda hook: None)
        monkeypatch.setattr(rospy, "get_param", lambda name, default: params.get(name, default))
        monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
        monkeypatch.setattr(actionlib, "SimpleActionClient", lambda *_: client)
        return send_goals_node.main(), client.sent

    return run


@pytest.mark.parametrize(("reaches", "code"), [(2, 0), (1, 1), (0, 1)])
def test_goals_are_sent_in_order_and_failures_set_the_exit_code(send, reaches, code):
    assert send(reaches, loop=False) == (code, [1, 2])


def test_a_loop_ends_after_a_round_that_reached_no_goal(send):
    assert send(3, loop=True) == (1, [1, 2, 1, 2, 1, 2])

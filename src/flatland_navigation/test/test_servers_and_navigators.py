"""A server is restarted while a navigator runs, and a navigator ends while its robot drives."""

import os
import shutil
import signal
import subprocess
import sys

import pytest
from flatland_msgs.srv import ChangeRate
from waiting import wait_until

pytestmark = pytest.mark.slow

CLIENT = """
import signal, sys
import actionlib, rospy
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import Odometry

def send_goal(x):
    client.wait_for_server()
    goal = MoveBaseGoal()
    goal.target_pose.header.frame_id = "map"
    goal.target_pose.pose.position.x = x
    goal.target_pose.pose.orientation.w = 1.0
    client.send_goal(goal)

def reach(x):
    send_goal(x)
    return result()

def result():
    client.wait_for_result()
    return client.get_goal_status_text()

def speed():
    return rospy.wait_for_message("odometry/ground_truth", Odometry, 20).twist.twist.linear.x

rospy.init_node("client")
client = actionlib.SimpleActionClient("move_base", MoveBaseAction)
for line in sys.stdin:
    signal.alarm(60)  # a call that does not return ends the client
    print(eval(line), flush=True)
"""


@pytest.fixture
def master(master):
    master.ask("setParam", "/use_sim_time", True)
    return master


@pytest.fixture
def start(master):
    """Starts a program under the master; it is ended after the test, as by Ctrl-C."""
    processes = []

    def start(*command, **pipes):
        process = subprocess.Popen(
            [sys.executable, *command],
            env={**os.environ, "ROS_MASTER_URI": master.uri},
            text=True,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            **pipes,
        )
        processes.append(process)
        return process

    yield start
    for process in reversed(processes):
        end(process)


def end(process):
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=20)


def go_at_five_times_real_time(server):
    assert server.call("/change_rate", ChangeRate, rate=5.0).success


def drive_away(ask):
    ask("send_goal(-4.0)")
    wait_until(lambda: float(ask("speed()")) > 0.1, "the robot to drive")


def test_a_navigator_survives_a_restarted_server(start, start_server, tmp_path):
    client = start("-c", CLIENT, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    log = tmp_path / "navigator.log"

    def ask(call):
        client.stdin.write(f"{call}\n")
        client.stdin.flush()
        return client.stdout.readline().strip()

    server = start_server()
    go_at_five_times_real_time(server)
    with log.open("w") as file:
        navigator = start(
            *(shutil.which("roslaunch"), "flatland_navigation", "waypoints.launch"),
            stdout=file,
            stderr=subprocess.STDOUT,
        )
    assert ask("reach(1.0)") == "the goal is reached"

    drive_away(ask)
    end_time = float(ask("rospy.get_time()"))
    server.process.send_signal(signal.SIGINT)
    assert server.process.wait(60) == 0
    server = start_server()
    assert ask("result()") == "simulated time has gone back"

    # Time is earlier than the stamps of the navigator's former goals.
    wait_until(lambda: 0.0 < float(ask("rospy.get_time()")) < end_time, "the client's new time")
    go_at_five_times_real_time(server)
    assert ask("reach(1.0)") == "the goal is reached"

    drive_away(ask)
    end(navigator)
    assert ask("speed()") == "0.0"
    assert "Traceback" not in log.read_text()

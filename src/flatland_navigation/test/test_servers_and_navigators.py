"""Launches in two terminals: a server is restarted, and a navigator ends."""

import os
import shutil
import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

ROSLAUNCH = (sys.executable, shutil.which("roslaunch"))
SERVER = ("flatland_server", "server.launch", "show_viz:=false", "update_rate:=1000")

CLIENT = """
import actionlib, rospy
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import Odometry
rospy.init_node("client")
client = actionlib.SimpleActionClient("move_base", MoveBaseAction)

def drive(x):
    client.wait_for_server()
    goal = MoveBaseGoal()
    goal.target_pose.header.frame_id = "map"
    goal.target_pose.pose.position.x = x
    goal.target_pose.pose.orientation.w = 1.0
    client.send_goal(goal)

def speed():
    return rospy.wait_for_message("odometry/ground_truth", Odometry, 20).twist.twist.linear.x
"""

REACH_A_GOAL = f"""{CLIENT}
drive(1.0)
client.wait_for_result()
print(client.get_goal_status_text())
"""

BEGIN_TO_DRIVE = f"""{CLIENT}
drive(-8.0)
while speed() < 0.1:
    pass
"""

MEASURE_SPEED = f"{CLIENT}\nprint(speed())"


class Terminal:
    """Runs commands under a ROS master."""

    def __init__(self, launch, folder):
        self._environment = {**os.environ, "ROS_MASTER_URI": launch.uri}
        self._folder = folder
        self._launch = launch
        self.started = []

    def output(self, program):
        """What a Python program prints."""
        result = subprocess.run(
            [sys.executable, "-c", program],
            env=self._environment,
            stdout=subprocess.PIPE,
            text=True,
            timeout=60,
            check=True,
        )
        return result.stdout.strip()

    def roslaunch(self, *arguments, until):
        """Starts a launch file, waits for a line of its output, and returns process and log."""
        log = self._folder / f"launch{len(self.started)}.log"
        with log.open("w") as file:
            process = subprocess.Popen(
                [*ROSLAUNCH, *arguments],
                env=self._environment,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            )
        self.started.append(process)
        self._launch.wait_until(lambda: until in log.read_text(), f'"{until}"')
        return process, log


def end(process):
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
        process.wait(20)


@pytest.fixture
def terminal(run, tmp_path):
    """A terminal, and a ROS master."""
    launch = run(command=(sys.executable, shutil.which("roscore")))
    launch.wait_for("started core service [/rosout]")
    terminal = Terminal(launch, tmp_path)
    yield terminal
    for process in terminal.started:
        end(process)


def test_a_navigator_survives_a_restarted_server_and_stops_the_robot_at_its_end(terminal):
    server, _ = terminal.roslaunch(*SERVER, until="running")
    navigator, log = terminal.roslaunch(
        "flatland_navigation", "waypoints.launch", until="process[move_base"
    )
    assert terminal.output(REACH_A_GOAL) == "the goal is reached"

    # Its time is behind that of the goal which the navigator knows.
    end(server)
    terminal.roslaunch(*SERVER, until="running")
    assert terminal.output(REACH_A_GOAL) == "the goal is reached"

    terminal.output(BEGIN_TO_DRIVE)
    end(navigator)
    assert terminal.output(MEASURE_SPEED) == "0.0"
    assert "Traceback" not in log.read_text()

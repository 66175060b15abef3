"""Launches as a user makes them, in two terminals: a navigator ends, and a server is started anew."""

import os
import shutil
import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

ROSLAUNCH = (sys.executable, shutil.which("roslaunch"))
SERVER = ("flatland_server", "server.launch", "show_viz:=false", "update_rate:=1000")

# What a program of the user's does: the topics and the action are move_base's.
CLIENT = """
import sys
import actionlib, rospy
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
rospy.init_node("client", disable_rostime=True)
client = actionlib.SimpleActionClient("move_base", MoveBaseAction)
client.wait_for_server()
goal = MoveBaseGoal()
goal.target_pose.header.frame_id = "map"
goal.target_pose.pose.position.x = float(sys.argv[1])
goal.target_pose.pose.orientation.w = 1.0
client.send_goal_and_wait(goal)
print(client.get_goal_status_text())
"""

VELOCITY = """
import rospy
from nav_msgs.msg import Odometry
rospy.init_node("velocity", disable_rostime=True)
topic = "odometry/ground_truth"
print(rospy.wait_for_message(topic, Odometry, 20).twist.twist.linear.x)
"""


class Terminal:
    """Runs commands under a ROS master."""

    def __init__(self, launch, folder):
        self._environment = {**os.environ, "ROS_MASTER_URI": launch.uri}
        self._folder = folder
        self.started = []

    def output(self, program, *arguments):
        command = [sys.executable, "-c", program, *arguments]
        result = subprocess.run(
            command,
            env=self._environment,
            stdout=subprocess.PIPE,
            text=True,
            timeout=60,
            check=True,
        )
        return result.stdout.strip()

    def launch(self, *arguments):
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
        return process, log


@pytest.fixture
def master(run, tmp_path):
    """A ROS master, and a terminal."""
    launch = run(command=(sys.executable, shutil.which("roscore")))
    launch.wait_for("started core service [/rosout]")
    terminal = Terminal(launch, tmp_path)
    yield launch, terminal
    for process in terminal.started:
        end(process)


def end(process):
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
        process.wait(20)


def test_the_robot_stops_with_its_navigator_and_both_survive_a_new_server(master):
    core, terminal = master
    server, log = terminal.launch(*SERVER)
    core.wait_until(lambda: "running" in log.read_text(), "the server")
    navigator, navigator_log = terminal.launch("flatland_navigation", "waypoints.launch")
    assert terminal.output(CLIENT, "1.0") == "the goal is reached"

    # Its time is behind that of the goals which the navigator knows.
    end(server)
    server, log = terminal.launch(*SERVER)
    core.wait_until(lambda: "running" in log.read_text(), "the second server")
    assert terminal.output(CLIENT, "1.0") == "the goal is reached"

    client = subprocess.Popen(
        [sys.executable, "-c", CLIENT, "-8.0"], env=terminal._environment, stdout=subprocess.DEVNULL
    )
    core.wait_until(lambda: float(terminal.output(VELOCITY)) > 0.1, "the robot to drive")
    end(navigator)
    assert float(terminal.output(VELOCITY)) == 0.0
    client.kill()
    client.wait()
    assert "Traceback" not in navigator_log.read_text()
